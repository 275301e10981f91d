// A band is as many rows of a cell's bitmap as fit a word. The last row of a band is the first row of the
// next one.

// The place of row y in a band that begins with row `first`, or the nearest end of the band.
FN u32 row_in_band(const u32 y, const u32 first, const u32 rows) { return min(max(y, first) - first, rows); }

// The part of the intervals from .. to (packed) in a band: bits x_from .. x_to of rows y_from .. y_to.
#define BAND_OF(name, band, from, to)                                                                    \
  const u64 name = ((U64(2u) << FIELD(to, 0u)) - (U64(1u) << FIELD(from, 0u))) *                         \
                   (rows_below[row_in_band(FIELD(to, 1u) + 1u, (band) * step_rows, rows)] -              \
                    rows_below[row_in_band(FIELD(from, 1u), (band) * step_rows, rows)]);
