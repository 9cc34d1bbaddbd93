"""`contbed animate DIR`: a transient run as a film, planes of two fluids and beds as
maps, particles from the side.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np

from contbed import fields
from contbed.errors import ContbedError
from contbed.output.files import atomic
from contbed.output.folder import list_file, require_own
from contbed.report.fields import Cloud, Pictures, pictures
from contbed.report.read import read_run

SUFFIXES = (".gif", ".mp4")
FRAMES_PER_SECOND = 10
MOST = 400  # frames of a film
DPI = 110
WIDTH = 6.0  # inches


def animate(
    folder: Path,
    file: Path | None = None,
    name: str | None = None,
    rate: int = FRAMES_PER_SECOND,
) -> Path:
    """Write the film of one field of a run and return its file.

    Parameters
    ----------
    folder : of a run with fields at several times
    file : a .gif or, where ffmpeg is there, a .mp4; animation.gif in the folder if None
    name : the field; of several the solids fraction, else the temperature of the solid,
        else the first
    rate : frames per second

    Raises
    ------
    ContbedError : the run has no fields at several times or no such field, or the film
        cannot be written
    """
    target = file or folder / "animation.gif"
    if file is None:
        require_own(target)
    if target.suffix not in SUFFIXES:
        raise ContbedError(
            f"{target}: a film is a .gif or a .mp4; give --out one of these"
        )
    found = {
        item.field.strip("|"): item
        for item in pictures(read_run(folder, folder.name), MOST)
        if len(item.times) > 1
    }
    if not found:
        raise ContbedError(
            f"{folder}: has no fields of a plane, a box or particles at several times; "
            "give time.times or time.fields "
            "in the scene and leave output.fields on"
        )
    if name is not None and name not in found:
        raise ContbedError(f"{folder}: no field {name!r}; there are {', '.join(found)}")
    usual = next(
        (field for field in ("eps_s", "T_solid") if field in found), next(iter(found))
    )
    _write(found[name or usual], target, rate)
    list_file(target)
    return target


def _write(item: Pictures | Cloud, target: Path, rate: int) -> None:
    import matplotlib
    from matplotlib.animation import FFMpegWriter, PillowWriter
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    (left, right), (bottom, top) = (
        item.box() if isinstance(item, Cloud) else (item.x[[0, -1]], item.y[[0, -1]])
    )
    ratio = float((top - bottom) / (right - left))
    with matplotlib.rc_context():
        if target.suffix == ".mp4":
            matplotlib.rcParams["animation.ffmpeg_path"] = _ffmpeg(target)
        width = WIDTH if ratio < 1.2 else max(3.0, WIDTH / ratio + 1.5)
        figure = Figure(
            figsize=(width, min(8.0, max(2.2, (width - 1.6) * ratio + 1.0))),
            dpi=DPI,
            layout="constrained",
        )
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        show = _cloud(axes, item) if isinstance(item, Cloud) else _map(axes, item)
        entry = fields.field(item.field.strip("|"))
        figure.colorbar(show[0], ax=axes, label=entry.label if entry else item.field)
        writer: Any = (FFMpegWriter if target.suffix == ".mp4" else PillowWriter)(
            fps=rate
        )
        with atomic(target) as temporary:
            path = temporary.with_name(f"{temporary.name}{target.suffix}")
            try:
                with writer.saving(figure, str(path), DPI):
                    for k, time in enumerate(item.times):
                        show[1](k)
                        axes.set_title(f"t = {time:.4g} s")
                        writer.grab_frame()
                path.replace(temporary)
            finally:
                path.unlink(missing_ok=True)


def _map(axes: Any, item: Pictures) -> tuple[Any, Any]:
    """Draw the first map; return it and what draws another one."""
    extent = (item.x[0], item.x[-1], item.y[0], item.y[-1])
    low, high = float(np.nanmin(item.frames)), float(np.nanmax(item.frames))
    image = axes.imshow(
        item.frames[0],
        origin="lower",
        extent=extent,
        vmin=low,
        vmax=high,
        aspect="equal",
    )
    axes.set(xlabel=f"{item.axes[0]} [m]", ylabel=f"{item.axes[1]} [m]")
    return image, lambda k: image.set_data(item.frames[k])


def _cloud(axes: Any, item: Cloud) -> tuple[Any, Any]:
    """Draw the particles at the first time; return them and what draws those of
    another time.
    """
    from matplotlib.collections import EllipseCollection

    across, along = item.box()
    axes.set(xlabel="x [m]", ylabel="z [m]", aspect="equal", xlim=across, ylim=along)
    spheres = EllipseCollection(
        [],
        [],
        [],
        units="xy",
        offset_transform=axes.transData,
        edgecolor="black",
        lw=0.2,
    )
    values = np.concatenate([value for *_, value in item.frames])
    spheres.set_clim(float(values.min()), float(values.max()))
    axes.add_collection(spheres)

    def draw(k: int) -> None:
        x, z, radius, value = item.frames[k]
        spheres.set(
            widths=2 * radius,
            heights=2 * radius,
            angles=np.zeros(1),
            offsets=np.column_stack([x, z]),
        )
        spheres.set_array(value)

    draw(0)
    return spheres, draw


def _ffmpeg(target: Path) -> str:
    """Return the program that writes .mp4."""
    if found := shutil.which("ffmpeg"):
        return found
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError as error:
        raise ContbedError(
            f"{target}: a .mp4 needs ffmpeg: pip install 'contbed[animation]', or "
            "write a .gif"
        ) from error
    return str(get_ffmpeg_exe())
