// Combines the sums of all lanes, and with REACH their reach, to those of the run.
// Reads: the sums, reach. Writes: sum.

STORE_SUM(sum[SUM_STRIDE * unit + SUM_VERTICES], lanes, vertices);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_EXTREME], lanes, extreme);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_VOLUME], lanes, volume);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_FIRST], lanes, first_x);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_FIRST + 1u], lanes, first_y);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_FIRST + 2u], lanes, first_z);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_SECOND], lanes, second_xx);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_SECOND + 1u], lanes, second_yy);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_SECOND + 2u], lanes, second_zz);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_SECOND + 3u], lanes, second_xy);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_SECOND + 4u], lanes, second_yz);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_SECOND + 5u], lanes, second_zx);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_AREA], lanes, area_x);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_AREA + 1u], lanes, area_y);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_AREA + 2u], lanes, area_z);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_LENGTH], lanes, length_x);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_LENGTH + 1u], lanes, length_y);
STORE_SUM(sum[SUM_STRIDE * unit + SUM_LENGTH + 2u], lanes, length_z);
#ifdef REACH
ONE_LANE {
  sum[SUM_STRIDE * unit + SUM_LOWEST] =
    U64(reach[0]) | (U64(reach[1]) << PACKED_STRIDE) | (U64(reach[2]) << (2u * PACKED_STRIDE));
  sum[SUM_STRIDE * unit + SUM_HIGHEST] =
    U64(reach[3]) | (U64(reach[4]) << PACKED_STRIDE) | (U64(reach[5]) << (2u * PACKED_STRIDE));
}
#endif
