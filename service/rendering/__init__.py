"""Pictures of meshes in numpy alone: small ones, in a millisecond, without a compiler."""
