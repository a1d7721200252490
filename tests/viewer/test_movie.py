import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from lingual.model import LingualError
from lingual.viewer.movie import frame_times, write_frames, write_movie, write_picture
from lingual.viewer.view_options import ViewOptions


def test_a_film_has_the_frames_and_size_asked_for(session, gl, tmp_path):
    seen = []
    path = write_movie(
        session, tmp_path / "film" / "a.mp4", width=161, height=90, frame_rate=20.0, end=0.5,
        progress=lambda done, total: seen.append((done, total)),
    )  # fmt: skip
    reader = imageio_ffmpeg.read_frames(str(path))
    meta = next(reader)
    frames = [np.frombuffer(frame, np.uint8) for frame in reader]
    assert meta["size"] == (162, 90)
    assert meta["codec"] == "h264"
    assert "yuv420p" in meta["pix_fmt"]
    assert len(frames) == 11
    assert seen == [(i + 1, 11) for i in range(11)]
    assert np.abs(frames[0].astype(int) - frames[5]).mean() > 0.5


def test_a_gif_is_animated(session, gl, tmp_path):
    path = write_movie(session, tmp_path / "a.gif", width=96, height=64, frame_rate=10.0, end=0.4)
    with Image.open(path) as image:
        assert image.n_frames >= 4
        assert image.size == (96, 64)


def test_pictures_are_numbered(session, gl, tmp_path):
    folder = tmp_path / "frames"
    paths = write_frames(session, folder, width=80, height=60, frame_rate=10.0, start=0.1, end=0.3)
    assert [p.name for p in paths] == ["frame_0000.png", "frame_0001.png", "frame_0002.png"]
    with Image.open(paths[-1]) as image:
        assert image.size == (80, 60)
        assert image.mode == "RGB"


def test_a_transparent_picture_keeps_its_alpha(session, gl, tmp_path):
    path = write_picture(
        session, tmp_path / "a.png", 0.2, width=80, height=60, options=ViewOptions(backdrop="transparent")
    )
    with Image.open(path) as image:
        alpha = np.asarray(image)[..., 3]
    assert alpha.min() == 0
    assert alpha.max() == 255


def test_slow_motion_has_more_pictures(session):
    assert len(frame_times(session, 50.0, 1.0, 0.0, None)) == 51
    assert len(frame_times(session, 50.0, 0.25, 0.0, None)) == 201


def test_what_cannot_be_written_is_said(session, tmp_path):
    with pytest.raises(LingualError, match=r"\.mp4 or \.gif"):
        write_movie(session, tmp_path / "a.avi")
    (tmp_path / "file").write_text("")
    with pytest.raises(LingualError, match="folder cannot be made"):
        write_movie(session, tmp_path / "file" / "a.mp4")
    (tmp_path / "b.mp4").mkdir()
    with pytest.raises(LingualError, match=r"b\.mp4"):
        write_movie(session, tmp_path / "b.mp4")
    with pytest.raises(LingualError, match="Nothing to film"):
        write_movie(session, tmp_path / "a.mp4", start=5.0)
