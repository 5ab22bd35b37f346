"""TIFF: pictures as they are stored, which Pillow would turn upright while it decodes them.

In      an opened TIFF.
Out     the same, its pixels in the sensor's frame, its orientation told as that of a JPEG.
"""

from PIL.ExifTags import Base
from PIL.TiffImagePlugin import IMAGELENGTH, IMAGEWIDTH, TiffImageFile


class StoredTiff(TiffImageFile):
    """A TIFF in the sensor's frame."""

    def take_stored_size(self) -> None:
        """Take the size of the stored pixels, not that of the upright picture."""
        self._size = (self.tag_v2[IMAGEWIDTH], self.tag_v2[IMAGELENGTH])

    def load_end(self) -> None:
        """End decoding while Pillow knows of no orientation."""
        exif = self.getexif()
        orientation = exif.pop(Base.Orientation, None)
        super().load_end()
        if orientation is not None:
            exif[Base.Orientation] = orientation


def as_stored(picture: TiffImageFile) -> StoredTiff:
    """An opened TIFF, not decoded yet, in the sensor's frame."""
    picture.__class__ = StoredTiff
    assert isinstance(picture, StoredTiff)
    picture.take_stored_size()
    return picture
