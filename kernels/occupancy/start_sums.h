// The sums of the run. Each lane has its own.

u64 vertices = U64(0u);
u64 extreme = U64(0u);
u64 volume = U64(0u);
u64 first_x = U64(0u);
u64 first_y = U64(0u);
u64 first_z = U64(0u);
u64 second_xx = U64(0u);
u64 second_yy = U64(0u);
u64 second_zz = U64(0u);
u64 second_xy = U64(0u);
u64 second_yz = U64(0u);
u64 second_zx = U64(0u);
u64 area_x = U64(0u);
u64 area_y = U64(0u);
u64 area_z = U64(0u);
u64 length_x = U64(0u);
u64 length_y = U64(0u);
u64 length_z = U64(0u);
#ifdef REACH
LANES(i, 6u) reach[i] = i < 3u ? PACKED_MOST : 0u;
#endif
