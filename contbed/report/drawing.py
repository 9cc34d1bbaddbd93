"""The sketch of a bed as a picture (SVG): a box with arrows for what enters and
leaves.
"""

from __future__ import annotations

from html import escape

from contbed.output.sketch import Sketch, Stream

UPRIGHT = (230.0, 150.0)  # width and height of a bed whose streams run upward
FLAT = (300.0, 90.0)  # of a line
ARROW = 44.0  # length of an arrow
APART = 28.0  # between two arrows of a side
LINE = 20.0  # height of a line of text
LETTER = 7.5  # mean width of a letter, for the space beside the box
OUTWARD = {
    "left": (-1.0, 0.0),
    "right": (1.0, 0.0),
    "top": (0.0, -1.0),
    "bottom": (0.0, 1.0),
}
COLOURS = {True: "#0072b2", False: "#a33b00", None: "#5c6773"}
HEADS = "".join(
    f'<marker id="head{colour[1:]}" viewBox="0 0 10 10" refX="9" refY="5" '
    'markerWidth="9" markerHeight="9" markerUnits="userSpaceOnUse" '
    f'orient="auto"><path d="M0 0L10 5L0 10z" fill="{colour}"/></marker>'
    for colour in COLOURS.values()
)


def svg(bed: Sketch) -> str:
    """Return the picture of a sketch as an element of HTML."""
    width, height = FLAT if bed.horizontal else UPRIGHT
    texts = LETTER * max((len(stream.text) for stream in bed.streams), default=0)
    beside = {side for side in ("left", "right", "wall") if bed.at(side)}
    middle = beside == ({"wall"} if bed.horizontal else set())
    left = 16.0 + (max(texts - 0.5 * width, 0.0) if middle else ARROW + texts)
    top = ARROW + LINE
    height = max(height, LINE * (len(bed.inside) + 1.5))
    parts = [
        f'<rect x="{left:g}" y="{top:g}" width="{width:g}" height="{height:g}" '
        'rx="6" fill="none" stroke="#1c2430" stroke-width="1.5"/>'
    ]
    first = top + 0.5 * height - LINE * (0.5 * len(bed.inside) - 0.75)
    for k, text in enumerate(bed.inside):
        parts.append(_text((left + 0.5 * width, first + LINE * k), text, "middle"))
    for side in (*OUTWARD, "wall"):
        for k, stream in enumerate(bed.at(side)):
            place = _place(side, k, bed.horizontal)
            parts.append(_arrow(stream, (left, top, width, height), *place))
    size = (2.0 * left + width, 2.0 * top + height)
    return (
        f'<svg class="sketch" viewBox="0 0 {size[0]:g} {size[1]:g}" '
        f'width="{size[0]:g}" role="img" aria-label="the bed and its streams">'
        f"<defs>{HEADS}</defs>{''.join(parts)}</svg>"
    )


def _place(side: str, number: int, horizontal: bool) -> tuple[str, float]:
    """Return the side of the box for the `number`-th stream of a side, and its shift
    from the middle of that side; walls stand above a line, and beside another bed.
    """
    if side == "wall":
        return ("top", 0.0) if horizontal else ("right", APART * (number - 0.5))
    return side, APART * (number - 0.5)


def _arrow(
    stream: Stream,
    box: tuple[float, float, float, float],
    side: str,
    shift: float,
) -> str:
    """Return an arrow across a side of the box (left, top, width, height) and its
    text.
    """
    left, top, width, height = box
    out_x, out_y = OUTWARD[side]
    x = left + 0.5 * width * (1.0 + out_x) + (shift if out_y else 0.0)
    y = top + 0.5 * height * (1.0 + out_y) + (shift if out_x else 0.0)
    ends = [(x + ARROW * out_x, y + ARROW * out_y), (x, y)]
    if out_x:
        beside = (ends[0][0] + 6.0 * out_x, y + 5.0)
        anchor = "end" if out_x < 0.0 else "start"
    else:
        before = shift < 0.0
        beside = (x + (-8.0 if before else 8.0), y + 0.6 * ARROW * out_y + 5.0)
        anchor = "end" if before else "start"
    if stream.inward is False:
        ends.reverse()
    colour = COLOURS[stream.inward]
    head = "" if stream.inward is None else f' marker-end="url(#head{colour[1:]})"'
    dashes = ' stroke-dasharray="4 3"' if stream.inward is None else ""
    (x0, y0), (x1, y1) = ends
    line = (
        f'<line x1="{x0:g}" y1="{y0:g}" x2="{x1:g}" y2="{y1:g}" stroke="{colour}" '
        f'stroke-width="2"{dashes}{head}/>'
    )
    return line + _text(beside, stream.text, anchor)


def _text(place: tuple[float, float], text: str, anchor: str) -> str:
    x, y = place
    return (
        f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" font-size="14">'
        f"{escape(text)}</text>"
    )
