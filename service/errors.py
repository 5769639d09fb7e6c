"""The service's exceptions, one per boundary. Each message says what was expected, what was found, and what to do.

ServiceError
├── SettingsError           an option or a variable of the environment
├── BundleError             a directory that is not a bundle this service can trust
├── ImageError              a picture that cannot be decoded
│   ├── ImageFormatError    not one of the formats that are read
│   ├── ImageTooLargeError  more pixels than are allowed
│   └── StrangeImageError   no model explains it
├── CategoryError           a category that is missing, or that no bundle serves
├── ShapeCodeError          a shape code that is none of the model's
├── NotReadyError           the bundles are not loaded and proven yet
└── InferenceError          a graph gave something that is no mesh
"""


class ServiceError(Exception):
    """Anything that a caller or an operator can mend."""


class SettingsError(ServiceError):
    pass


class BundleError(ServiceError):
    pass


class ImageError(ServiceError):
    pass


class ImageFormatError(ImageError):
    pass


class ImageTooLargeError(ImageError):
    pass


class StrangeImageError(ImageError):
    pass


class CategoryError(ServiceError):
    pass


class ShapeCodeError(ServiceError):
    pass


class NotReadyError(ServiceError):
    pass


class InferenceError(ServiceError):
    pass
