"""Pictures as people have them, made into pictures as a model sees them: decoded, cut out, set on black, framed.

Trainer and service prepare their pictures by the same functions. Needs numpy and Pillow; never torch, never numba.
"""
