// Grids over the cube around the unit sphere, each half as fine as the one before. Twin: src/engine/render/environment.rs.

// Cells along each side of the finest grid.
const SKY_SIDE: u32 = 64u;
