"""A frame as a picture that a browser shows."""

import io

from PIL import Image

from irtiming.session.frame_views import FrameView


def jpeg(view: FrameView) -> bytes:
    """Its greys as JPEG."""
    file = io.BytesIO()
    Image.fromarray(view.grey).save(file, "JPEG", quality=90)
    return file.getvalue()
