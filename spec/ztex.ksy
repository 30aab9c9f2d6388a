# SPDX-License-Identifier: Apache-2.0
meta:
  id: ztex
  title: .ztex texture container, version 1.0
  file-extension: ztex
  endian: le
  ks-version: 0.9
doc: |
  The layout of spec/ztex.md, spec/zipmap.md, spec/silmap.md and spec/umbrella.md. It checks magics and fixed fields only; the rules are in the documents.
  Chunks with codec 1 are left as bytes, since the grammar does not decode Zstandard.
seq:
  - id: preamble
    type: preamble
  - id: directory
    type: entry
    repeat: expr
    repeat-expr: preamble.chunk_count
instances:
  chunks:
    type: chunk(_index)
    repeat: expr
    repeat-expr: preamble.chunk_count
types:
  preamble:
    seq:
      - id: magic
        contents: [0xab, 0x5a, 0x54, 0x45, 0x58, 0xbb, 0x0d, 0x0a, 0x1a, 0x0a]
      - id: major
        type: u2
        valid: 1
      - id: minor
        type: u2
      - id: reserved14
        type: u2
        valid: 0
      - id: file_size
        type: u8
      - id: directory_size
        type: u4
      - id: chunk_count
        type: u4
        valid:
          min: 3
          max: 65535
      - id: required_features
        type: u8
      - id: reserved40
        type: u8
        valid: 0
      - id: reserved48
        type: u8
        valid: 0
      - id: directory_hash
        type: u8
  entry:
    seq:
      - id: type
        type: str
        size: 4
        encoding: ASCII
      - id: version
        type: u2
      - id: flags
        type: u1
      - id: codec
        type: u1
        enum: codec
      - id: offset
        type: u8
      - id: stored_size
        type: u8
      - id: decoded_size
        type: u8
      - id: stored_hash
        type: u8
      - id: decoded_hash
        type: u8
    instances:
      is_critical:
        value: (flags & 1) != 0
      is_safe_to_copy:
        value: (flags & 2) != 0
  head:
    seq:
      - id: head_magic
        contents: [0xab, 0x5a, 0x54, 0x63, 0x68, 0x6b, 0xbb, 0x0a]
      - id: index
        type: u4
      - id: reserved
        type: u4
        valid: 0
      - id: entry
        type: entry
  chunk:
    params:
      - id: index
        type: s4
    instances:
      entry:
        value: _root.directory[index]
      head:
        io: _root._io
        pos: entry.offset
        type: head
      raw:
        io: _root._io
        pos: entry.offset + 64
        size: entry.stored_size
        if: entry.codec != codec::raw or entry.version != 1
      body:
        io: _root._io
        pos: entry.offset + 64
        size: entry.stored_size
        if: entry.codec == codec::raw and entry.version == 1
        type:
          switch-on: entry.type
          cases:
            '"TEXS"': texs
            '"IMAG"': imag
            '"ZPMP"': zpmp
            '"SLMP"': slmp
            '"UMBR"': umbr
            '"META"': meta_pairs
  texs:
    seq:
      - id: texture_count
        type: u4
      - id: layer_total
        type: u4
      - id: name_bytes
        type: u4
      - id: reserved
        type: u4
        valid: 0
      - id: textures
        type: texture
        repeat: expr
        repeat-expr: texture_count
      - id: layers
        type: layer
        repeat: expr
        repeat-expr: layer_total
      - id: names
        type: name(_index)
        repeat: expr
        repeat-expr: texture_count
  texture:
    seq:
      - id: kind
        type: u1
        enum: kind
      - id: wrap_u
        type: u1
        enum: wrap
      - id: wrap_v
        type: u1
        enum: wrap
      - id: wrap_w
        type: u1
        enum: wrap
      - id: layer_count
        type: u4
      - id: name_size
        type: u4
        valid:
          max: 255
      - id: reserved
        type: u4
        valid: 0
  layer:
    seq:
      - id: semantic
        type: u2
      - id: reserved
        type: u2
        valid: 0
      - id: image
        type: u4
  name:
    params:
      - id: index
        type: s4
    seq:
      - id: text
        type: str
        size: _parent.as<texs>.textures[index].name_size
        encoding: UTF-8
  imag:
    seq:
      - id: image_count
        type: u4
      - id: unit_total
        type: u4
      - id: reserved
        type: u8
        valid: 0
      - id: images
        type: image
        repeat: expr
        repeat-expr: image_count
      - id: units
        type: unit
        repeat: expr
        repeat-expr: unit_total
  image:
    seq:
      - id: format
        type: u4
      - id: width
        type: u4
      - id: height
        type: u4
      - id: depth
        type: u4
      - id: layers
        type: u4
      - id: levels
        type: u1
      - id: tile_log2
        type: u1
      - id: block_width
        type: u1
      - id: block_height
        type: u1
      - id: block_bytes
        type: u1
      - id: alpha_mode
        type: u1
        enum: alpha_mode
      - id: layer_kind
        type: u1
        enum: layer_kind
      - id: primaries
        type: u1
      - id: transfer
        type: u1
      - id: matrix
        type: u1
        valid: 0
      - id: full_range
        type: u1
        valid: 1
      - id: reserved
        type: u1
        valid: 0
  unit:
    doc: A place in the stored bytes of TEXL, which begins with one tile_record a tile.
    seq:
      - id: offset
        type: u8
      - id: size
        type: u8
      - id: index_hash
        type: u8
  tile_record:
    seq:
      - id: stored_size
        type: u4
      - id: codec
        type: u1
        enum: codec
      - id: reserved
        size: 3
      - id: hash
        type: u8
  meta_pairs:
    seq:
      - id: pair_count
        type: u4
      - id: reserved
        type: u4
        valid: 0
      - id: sizes
        type: pair_sizes
        repeat: expr
        repeat-expr: pair_count
      - id: pairs
        type: pair(_index)
        repeat: expr
        repeat-expr: pair_count
  pair_sizes:
    seq:
      - id: key_size
        type: u4
      - id: value_size
        type: u4
  pair:
    params:
      - id: index
        type: s4
    seq:
      - id: key
        type: str
        size: _parent.as<meta_pairs>.sizes[index].key_size
        encoding: UTF-8
      - id: value
        type: str
        size: _parent.as<meta_pairs>.sizes[index].value_size
        encoding: UTF-8
  zpmp:
    doc: |
      The planes are parent, source_kind, source (one for each layer), mask, m00, m01, m02, m10 ... m22.
    seq:
      - id: patch_count
        type: u4
      - id: layer_count
        type: u4
      - id: reserved
        type: u8
        valid: 0
      - id: planes
        type: plane
        repeat: expr
        repeat-expr: 12 + layer_count
  slmp:
    doc: |
      The planes are cells, samples, minified.
    seq:
      - id: cells_x
        type: u4
        valid:
          min: 1
          max: 1048576
      - id: cells_y
        type: u4
        valid:
          min: 1
          max: 1048576
      - id: cell_layers
        type: u4
        valid:
          min: 1
          max: 65536
      - id: layer_count
        type: u4
      - id: filter
        type: u1
        enum: silmap_filter
      - id: reserved
        contents: [0, 0, 0, 0, 0, 0, 0]
      - id: planes
        type: plane
        repeat: expr
        repeat-expr: 3
  umbr:
    doc: |
      The planes are level_umbrellas, level_bits, base_kind, base_source, base_aspect, base_vertices, base_morph, base_variants, base_x, base_y,
      base_ellipsoid, base_height, base_curvature, vertex_x, vertex_y, morph_x, morph_y, variant_r, variant_g, variant_b, form, base, x, y, a, b,
      morph, variant_0, variant_1, variant_weight, strength, ellipsoid, height, curvature, lift, vertices, explicit_x, explicit_y, explicit_r,
      explicit_g, explicit_b, list_size, entry, shift.
    seq:
      - id: grid_x
        type: u4
        valid:
          min: 1
          max: 8192
      - id: grid_y
        type: u4
        valid:
          min: 1
          max: 8192
      - id: level_count
        type: u4
        valid:
          min: 1
          max: 14
      - id: base_count
        type: u4
        valid:
          max: 65536
      - id: umbrella_count
        type: u4
        valid:
          max: 16777216
      - id: base_vertex_count
        type: u4
      - id: morph_vertex_count
        type: u4
      - id: variant_colour_count
        type: u4
      - id: explicit_vertex_count
        type: u4
      - id: entry_count
        type: u4
      - id: longest_list
        type: u4
      - id: colour_mode
        type: u1
        enum: colour_mode
      - id: background_kind
        type: u1
        enum: background_kind
      - id: reserved46
        contents: [0, 0]
      - id: background_source
        type: u4
      - id: background
        type: f4
        repeat: expr
        repeat-expr: 4
      - id: mean
        type: f4
        repeat: expr
        repeat-expr: 4
      - id: prism_height
        type: f4
      - id: taper_start
        type: f4
      - id: taper_end
        type: f4
      - id: layer_count
        type: u4
        valid: 1
      - id: reserved100
        type: u4
        valid: 0
      - id: planes
        type: plane
        repeat: expr
        repeat-expr: 44
  plane:
    seq:
      - id: element_size
        type: u1
        valid:
          any-of: [1, 2, 4, 8]
      - id: predictor
        type: u1
        enum: predictor
      - id: packing
        type: u1
        enum: packing
      - id: codec
        type: u1
        enum: codec
      - id: bit_width
        type: u1
      - id: reserved
        size: 3
      - id: base
        type: u8
      - id: count
        type: u4
      - id: stored_size
        type: u4
      - id: hash
        type: u8
      - id: stored
        size: stored_size
enums:
  codec:
    0: raw
    1: zstd
    2: pred
    3: draco_seq
    4: fields
  kind:
    0: image
    1: zipmap
    2: silmap
    3: umbrellas
  wrap:
    0: repeat
    1: mirrored_repeat
    2: clamp_to_edge
    3: border
  alpha_mode:
    0: none
    1: straight
    2: premultiplied
  layer_kind:
    0: array
    1: cube
    2: frames
  silmap_filter:
    0: continuous
    1: sen2004
    2: nearest
  colour_mode:
    0: barycentric
    1: inverse_distance
  background_kind:
    0: colour
    1: image
    2: texture
  predictor:
    0: none
    1: delta
    2: second
  packing:
    0: elements
    1: byte_planes
    2: bits
