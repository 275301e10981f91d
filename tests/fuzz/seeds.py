#!/usr/bin/env python3
"""Writes the first inputs of the fuzz targets into FOLDER/TARGET: small files of every variant that a reader knows,
expressions, and random bytes for the targets that make boxes of them.

usage: seeds.py FOLDER"""

import gzip
import pathlib
import random
import struct
import sys
import zlib

folder = pathlib.Path(sys.argv[1])
random.seed(1)
VOXELS = [0, 1, 2, 3, 0, 0, 5, 7, 0, 9, 1, 0, 0, 0, 1, 1, 2, 0, 4, 200, 1, 0, 1, 0]  # 4 x 3 x 2


def write(target, name, content):
    (folder / target).mkdir(parents=True, exist_ok=True)
    (folder / target / name).write_bytes(content if isinstance(content, bytes) else content.encode())


def numbers(kind, values=None, order="<"):
    values = VOXELS if values is None else values
    return struct.pack(f"{order}{len(values)}{kind}", *[v % 128 if kind == "b" else v for v in values])


def npy(name, descr, shape, data, fortran=False, version=1):
    header = f"{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}\n".encode()
    length = struct.pack("<H" if version == 1 else "<I", len(header))
    write("npy", name, b"\x93NUMPY" + bytes([version, 0]) + length + header + data)


def csv_files():
    header = "xmin,ymin,zmin,xmax,ymax,zmax\n"
    write("csv", "plain", "0,0,0,1,1,1\n1,1,1,2,2,2\n")
    write("csv", "header", header + "0,0,0,1,1,1\n")
    write("csv", "spaces", "\ufeff# boxes\r\n\r\n X MIN,ymin,zmin,xmax,ymax,zmax \r\n 0 , +0.5e1 ,-1e-300,1, 6,\t7\r\n")
    write("csv", "bad", header + "0,0,0,1,1,1\n0,0,nan,1,1,inf\n")
    write("csv", "few", "1,2,3\n")
    write("csv", "range", "-1e999,0,0,1,1,1\n")


def npy_files():
    boxes = [0, 0, 0, 2, 2, 2, 1, 1, 1, 3, 3, 3]
    for descr, kind in (("<i4", "i"), (">i4", "i"), ("<i8", "q"), ("<f4", "f"), ("<f8", "d"), (">f8", "d")):
        data = numbers(kind, boxes, descr[0])
        npy("boxes" + descr.strip("<") + kind, descr, "(2, 6)", data)
        npy("fortran" + descr.strip("<") + kind, descr, "(2, 6)", data, fortran=True, version=2)
    for descr, kind in (("|b1", "B"), ("|u1", "B"), ("|i1", "b"), ("<u2", "H"), (">i2", "h"), ("<u4", "I"),
                        ("<i8", "q"), ("<u8", "Q"), ("<f4", "f"), (">f8", "d")):
        npy("volume" + descr.strip("<|"), descr, "(2, 3, 4)", numbers(kind, order=descr[0].replace("|", "<")))
    npy("volume_fortran", "|u1", "(2, 3, 4)", numbers("B"), fortran=True, version=3)
    npy("empty", "<f8", "(0, 6)", b"")


def nrrd_files():
    for name, kind, code in (("u8", "uchar", "B"), ("i16", "short", "h"), ("f64", "double", "d")):
        common = f"NRRD0004\n# made by a script\ntype: {kind}\ndimension: 3\nsizes: 4 3 2\nendian: little\n"
        data = numbers(code)
        write("nrrd", name, (common + "encoding: raw\n\n").encode() + data)
        write("nrrd", name + "_gzip", (common + "encoding: gzip\n\n").encode() + gzip.compress(data, mtime=0))
    common = "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n"
    write("nrrd", "space", (common + "space: left-posterior-superior\nspace directions: (0,-2,0) (1,0,0) (0,0,0.5)\n"
                            "space origin: (1,2,3)\nkey:=value\n\n").encode() + numbers("B"))
    write("nrrd", "spacings", (common + "spacings: 1 2 3\naxis mins: 0 nan 1\ncenters: node cell node\n"
                               "line skip: 1\nbyte skip: 2\n\n").encode() + b"skipped\nxx" + numbers("B"))
    write("nrrd", "last", (common + "byte skip: -1\n\n").encode() + b"skipped" + numbers("B"))


def metaimage_files():
    common = "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\n"
    for name, kind, code in (("u8", "MET_UCHAR", "B"), ("i16", "MET_SHORT", "h"), ("f64", "MET_DOUBLE", "d")):
        end = f"ElementType = {kind}\nElementDataFile = LOCAL\n"
        data = numbers(code)
        write("mha", name, (common + end).encode() + data)
        packed = zlib.compress(data)
        write("mha", name + "_zlib", (common + "CompressedData = True\n" + end).encode() + packed)
        write("mha", name + "_size", (common + f"CompressedData = True\nCompressedDataSize = {len(packed)}\n"
                                      + end).encode() + packed)
    write("mha", "place", (common + "Offset = 1 2 3\nElementSpacing = 1 0.5 2\nTransformMatrix = 0 1 0 -1 0 0 0 0 1\n"
                           "BinaryDataByteOrderMSB = True\nHeaderSize = -1\nElementType = MET_USHORT\n"
                           "ElementDataFile = LOCAL\n").encode() + b"x" + numbers("H", order=">"))


def tiff_page(order, entries, pixels, at, last, big=False):
    """A directory at offset `at`, with its pixels behind it."""
    count, size, offset = ("Q", 20, "Q") if big else ("H", 12, "I")
    entries = sorted(entries + [(273, 4, 0), (279, 4, len(pixels))])
    length = struct.calcsize(order + count) + size * len(entries) + struct.calcsize(order + offset)
    page = struct.pack(order + count, len(entries))
    for tag, kind, value in entries:
        value = at + length if tag == 273 else value
        packed = struct.pack(order + {3: "H", 4: "I"}[kind], value)
        page += struct.pack(order + "HH" + offset, tag, kind, 1) + packed.ljust(8 if big else 4, b"\0")
    behind = at + length + len(pixels)
    return page + struct.pack(order + offset, 0 if last else behind) + pixels


def tiff_files():
    def stack(name, kind, bits, sample_format=1, compression=1, order="<", tiles=False, big=False):
        mark = b"II" if order == "<" else b"MM"
        content = mark + (struct.pack(order + "HHHQ", 43, 8, 0, 16) if big else struct.pack(order + "HI", 42, 8))
        for z in range(2):
            pixels = numbers(kind, VOXELS[12 * z:12 * z + 12], order)
            shape = [(278, 3, 3)]
            if tiles:
                pixels = bytes(16 * 16 * bits // 8)
                shape = [(322, 3, 16), (323, 3, 16)]
            if compression == 8:
                pixels = zlib.compress(pixels)
            if compression == 32773:  # PackBits, of literal runs
                pixels = bytes([len(pixels) - 1]) + pixels
            entries = [(256, 3, 4), (257, 3, 3), (258, 3, bits), (259, 3, compression), (262, 3, 1), (277, 3, 1),
                       (339, 3, sample_format)] + shape
            if tiles:
                page = tiff_page(order, entries, pixels, len(content), z == 1, big)
                page = page.replace(struct.pack(order + "HH", 273, 4), struct.pack(order + "HH", 324, 4))
                page = page.replace(struct.pack(order + "HH", 279, 4), struct.pack(order + "HH", 325, 4))
            else:
                page = tiff_page(order, entries, pixels, len(content), z == 1, big)
            content += page
        write("tif", name, content)

    stack("u8", "B", 8)
    stack("i16_big_endian", "h", 16, sample_format=2, order=">")
    stack("u32_bigtiff", "I", 32, big=True)
    stack("f32_deflate", "f", 32, sample_format=3, compression=8)
    stack("u8_packbits", "B", 8, compression=32773)
    stack("f64", "d", 64, sample_format=3)
    stack("tiles", "B", 8, tiles=True)
    stack("tiles_deflate", "H", 16, tiles=True, compression=8)


def chunk(name, content, children=b""):
    return name + struct.pack("<II", len(content), len(children)) + content + children


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def dictionary(**values):
    return struct.pack("<I", len(values)) + b"".join(text(k) + text(v) for k, v in values.items())


def vox_files():
    def model(size, voxels):
        return (chunk(b"SIZE", struct.pack("<III", *size))
                + chunk(b"XYZI", struct.pack("<I", len(voxels)) + b"".join(bytes(v) for v in voxels)))

    def save(name, chunks, version=150):
        write("vox", name, b"VOX " + struct.pack("<I", version) + chunk(b"MAIN", b"", chunks))

    first = model((3, 2, 2), [(0, 0, 0, 1), (1, 0, 0, 2), (2, 1, 1, 79)])
    second = model((256, 200, 16), [(255, 0, 3, 1), (250, 9, 9, 200)])
    save("one", first)
    save("two", first + second, 200)
    number = lambda *values: struct.pack(f"<{len(values)}i", *values)
    nodes = (chunk(b"nTRN", number(0) + dictionary(_name="root") + number(1, -1, -1, 1) + dictionary())
             + chunk(b"nGRP", number(1) + dictionary() + number(2, 2, 4))
             + chunk(b"nTRN", number(2) + dictionary() + number(3, -1, 0, 1) + dictionary(_t="5 -3 10", _r="40"))
             + chunk(b"nSHP", number(3) + dictionary() + number(1, 0) + dictionary())
             + chunk(b"nTRN", number(4) + dictionary(_hidden="1") + number(5, -1, 0, 1) + dictionary(_r="17"))
             + chunk(b"nSHP", number(5) + dictionary() + number(1, 1) + dictionary()))
    save("scene", first + second + nodes + chunk(b"RGBA", bytes(16)), 200)


def expressions():
    for i, line in enumerate(("A", "A and B not C", "(A or B) & (C xor D) - E", "A not (B not (C not D))",
                              "metal_1 AND NOT (Via2 | _x) ^ metal_1", "((A^B)^(C^D))^((E^F)^(G^H))", "not A", "A or")):
        write("expression", str(i), line)


def boxes():
    for target in ("unite", "models", "combine"):
        for size in (8, 40, 150, 400):
            write(target, str(size), random.randbytes(size))


csv_files()
npy_files()
nrrd_files()
metaimage_files()
tiff_files()
vox_files()
expressions()
boxes()
