"""Loops over the pixels of boxes.

As those of `nvcore.metrics.kernels` they release the interpreter lock, so that threads share the
pictures. Each row of a rectangle is at most three stretches: surround, pedestrian, surround. Loops
over a stretch begin at 0 and are kept apart where that lets the compiler work on several pixels at
a time.
"""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled

PEDESTRIAN = 0
SURROUND = 1


@compiled
def stretch_of_row(y, part, inner, outer):
    """First column of a stretch in row y, and one past its last; the second is the pedestrian."""
    if not inner[1] <= y < inner[3]:
        return outer[0], outer[2] if part == 0 else outer[0]
    if part == 0:
        return outer[0], inner[0]
    if part == 1:
        return inner[0], inner[2]
    return inner[2], outer[2]


@compiled
def light_sums(padded, inner, outer, count, luminance, squares, edges):
    """Sums over pedestrian and surround of each box: pixels, luminance, its square, its gradient.

    Sums of a row are of 32 bits: enough for pictures up to 66,000 px wide.

    Parameters
    ----------
    padded
        Luminance, uint8, (h + 2, w + 2), the edge repeated once on each side.
    inner, outer
        Of `Regions`.
    count, luminance, squares, edges
        Out: (n, 2), pedestrian and surround. The gradient is that of the 3 x 3 Sobel operator.
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
                # four in turn: one would have to wait for the sum before
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
    """Sums of the curved X, Y and Z, and histograms of R, G and B, of each box.

    Parameters
    ----------
    picture
        RGB, uint8, (h, w, 3).
    inner, outer
        Of `Regions`.
    shift
        By so many bits a value is shifted to its bin.
    linear, to_place, lines
        Tables of `nvcore.driver.features.compute`.
    curved
        Out: (n, 2, 3), pedestrian and surround.
    histogram
        Added to: (n, 2, 3, bins), int64.
    """
    xr, xg, xb = to_place[0]
    yr, yg, yb = to_place[1]
    zr, zg, zb = to_place[2]
    # two in turn, and a count for each value: neighbours are much alike, and would wait for each
    # other's count
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
