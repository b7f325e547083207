"""The compiled loops of training and detection.

As those of `nvcore.metrics.kernels` they take a range (``lo``, ``hi``), release the interpreter
lock and write into arrays that the caller made, so that threads share the work. No result depends
on where a range ends. Sums over rectangles are differences of four values of an integral image of
32 bits, taken modulo 2^32: exact for a picture of any size.
"""
