"""Compiled loops over the pixels of boxes.

Like those of `nvcore.metrics.kernels`, they release the interpreter lock, so that threads can
process pictures in parallel. Each row of a rectangle has up to three segments: surround,
pedestrian, surround. Loops over a segment start at 0 and are kept separate if that lets the
compiler vectorise them.
"""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled

PEDESTRIAN = 0
SURROUND = 1


@compiled
def stretch_of_row(y, part, inner, outer):
    """Return first column, and one past the last, of a segment in a row. Part 1 is the box."""
    if not inner[1] <= y < inner[3]:
        return outer[0], outer[2] if part == 0 else outer[0]
    if part == 0:
        return outer[0], inner[0]
    if part == 1:
        return inner[0], inner[2]
    return inner[2], outer[2]


@compiled
def light_sums(padded, inner, outer, count, luminance, squares, edges):
    """Sum pixels, luminance, its square and its gradient over pedestrian and surround of each box.

    Sums of a row have 32 bits, which is enough for pictures up to 66,000 px wide.

    Parameters
    ----------
    padded
        Luminance, uint8, (h + 2, w + 2), the edge repeated once on each side.
    inner, outer
        Rectangles as in `Regions`.
    count, luminance, squares, edges
        Output, (n, 2), pedestrian and surround. The gradient is from the 3 x 3 Sobel operator.
    """
    strength = np.empty(padded.shape[1], np.float32)
    for box in range(len(inner)):
        for y in range(outer[box, 1], outer[box, 3]):
            for part in range(3):
                first, last = stretch_of_row(y, part, inner[box], outer[box])
                n = last - first
                if n <= 0:
                    continue
                up = padded[y, first : last + 2]
                at = padded[y + 1, first : last + 2]
                down = padded[y + 2, first : last + 2]
                total, square = np.uint32(0), np.uint32(0)
                for i in range(n):
                    value = np.uint32(at[i + 1])
                    total += value
                    square += value * value
                for i in range(n):
                    gx = np.int32(up[i + 2]) - np.int32(up[i])
                    gx += np.int32(down[i + 2]) - np.int32(down[i])
                    gx += np.int32(2) * (np.int32(at[i + 2]) - np.int32(at[i]))
                    gy = np.int32(down[i]) - np.int32(up[i])
                    gy += np.int32(down[i + 2]) - np.int32(up[i + 2])
                    gy += np.int32(2) * (np.int32(down[i + 1]) - np.int32(up[i + 1]))
                    across, along = np.int32(gx), np.int32(gy)
                    strength[i] = np.sqrt(np.float32(across * across + along * along))
                # four sums in turn, so that no addition waits for the previous one
                first_sum, second_sum, third_sum, fourth_sum = 0.0, 0.0, 0.0, 0.0
                whole = n // 4 * 4
                for i in range(0, whole, 4):
                    first_sum += np.float64(strength[i])
                    second_sum += np.float64(strength[i + 1])
                    third_sum += np.float64(strength[i + 2])
                    fourth_sum += np.float64(strength[i + 3])
                for i in range(whole, n):
                    first_sum += np.float64(strength[i])
                region = PEDESTRIAN if part == 1 else SURROUND
                count[box, region] += n
                luminance[box, region] += total
                squares[box, region] += square
                edges[box, region] += (first_sum + second_sum) + (third_sum + fourth_sum)


@compiled
def colour_sums(picture, inner, outer, shift, linear, to_place, lines, curved, histogram):
    """Sum the curved X, Y and Z, and compute histograms of R, G and B, for each box.

    Parameters
    ----------
    picture
        RGB, uint8, (h, w, 3).
    inner, outer
        Rectangles as in `Regions`.
    shift
        Number of bits by which a value is shifted to get its bin.
    linear, to_place, lines
        Tables of `nvcore.subjects.driver.features.compute`.
    curved
        Output, (n, 2, 3), pedestrian and surround.
    histogram
        Output to which counts are added, (n, 2, 3, bins), int64.
    """
    xr, xg, xb = to_place[0]
    yr, yg, yb = to_place[1]
    zr, zg, zb = to_place[2]
    # two in turn, with a counter each: neighbouring pixels are much alike, and would otherwise wait
    # for each other's counter
    counts = np.zeros((2, 2, 3, 256), np.int32)
    for box in range(len(inner)):
        counts[:] = 0
        for y in range(outer[box, 1], outer[box, 3]):
            for part in range(3):
                first, last = stretch_of_row(y, part, inner[box], outer[box])
                n = last - first
                if n <= 0:
                    continue
                region = PEDESTRIAN if part == 1 else SURROUND
                row = picture[y, first:last]
                sum_x, sum_y, sum_z = 0.0, 0.0, 0.0
                for i in range(n):
                    turn = i & 1
                    red, green, blue = row[i, 0], row[i, 1], row[i, 2]
                    counts[turn, region, 0, red] += 1
                    counts[turn, region, 1, green] += 1
                    counts[turn, region, 2, blue] += 1
                    r, g, b = linear[red], linear[green], linear[blue]
                    place = xr * r + xg * g + xb * b
                    step = np.uint64(np.int32(place))
                    sum_x += lines[step, 0] + place * lines[step, 1]
                    place = yr * r + yg * g + yb * b
                    step = np.uint64(np.int32(place))
                    sum_y += lines[step, 0] + place * lines[step, 1]
                    place = zr * r + zg * g + zb * b
                    step = np.uint64(np.int32(place))
                    sum_z += lines[step, 0] + place * lines[step, 1]
                curved[box, region, 0] += sum_x
                curved[box, region, 1] += sum_y
                curved[box, region, 2] += sum_z
        for region in range(2):
            for channel in range(3):
                for value in range(256):
                    pixels = counts[0, region, channel, value] + counts[1, region, channel, value]
                    histogram[box, region, channel, value >> shift] += pixels
