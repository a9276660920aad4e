//! Where the tiles of hemicubes lie in one large texture.

/// Tiles of a hemicube's picture.
pub const TILES_PER_HEMICUBE: usize = 3;

/// What an atlas may take, IDs and depths, bytes: some hundred tiles of 100 x 100 pixels, enough to
/// keep a large GPU busy. A larger tile is an atlas of its own. Not tuned.
const ATLAS_BUDGET: u64 = 64 << 20;
/// The longest side of an atlas, pixels, even where an adapter allows more.
const MAX_SIDE: u32 = 8192;
/// The most tiles in an atlas: their faces, two in most of them, are what one dispatch can count in one
/// dimension.
const MAX_TILES: u32 = 65_535 / 2;

/// Square tiles in rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtlasLayout {
    /// Pixels along a tile.
    pub resolution: u32,
    /// Tiles in a row.
    pub columns: u32,
    /// Rows of tiles.
    pub rows: u32,
}

impl AtlasLayout {
    /// As many tiles as the budget allows, at least one; `None` where one is longer than `max_side`.
    pub fn new(resolution: u32, max_side: u32) -> Option<Self> {
        let per_side = max_side.min(MAX_SIDE) / resolution;
        let bytes_per_tile = 8 * u64::from(resolution).pow(2);
        let tiles = (ATLAS_BUDGET / bytes_per_tile).clamp(1, MAX_TILES.into()) as u32;
        let columns = tiles.isqrt().min(per_side);
        let rows = tiles.checked_div(columns)?.min(per_side);
        Some(Self {
            resolution,
            columns,
            rows,
        })
    }

    /// Tiles it has room for.
    pub fn tiles(self) -> u32 {
        self.columns * self.rows
    }

    /// First column and row, pixels, of a tile of the `hemicube`-th of all hemicubes of a scene.
    ///
    /// The place depends on nothing else: GPUs round corners by where in the atlas they are, and a
    /// row must have the same bits whatever it is drawn together with. Tiles that follow each other
    /// have places that follow each other, the last being followed by the first.
    pub fn origin(self, hemicube: u64, tile: usize) -> [u32; 2] {
        let tile = hemicube * TILES_PER_HEMICUBE as u64 + tile as u64;
        let place = (tile % u64::from(self.tiles())) as u32;
        [place % self.columns, place / self.columns].map(|k| k * self.resolution)
    }

    /// Its size, pixels.
    pub fn size(self) -> wgpu::Extent3d {
        wgpu::Extent3d {
            width: self.columns * self.resolution,
            height: self.rows * self.resolution,
            depth_or_array_layers: 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_fit_the_largest_texture_and_do_not_overlap() {
        for resolution in [2, 4, 100, 128, 500, 2048, 3000, 4096] {
            for max_side in [4096, 8192, 16384] {
                let layout = AtlasLayout::new(resolution, max_side).unwrap();
                assert!(layout.tiles() >= 1 && layout.tiles() <= MAX_TILES);
                let size = layout.size();
                assert!(size.width <= max_side && size.height <= max_side);
                let tiles = u64::from(layout.tiles());
                let mut origins: Vec<_> = (0..tiles.min(3000))
                    .map(|k| layout.origin(k / 3, (k % 3) as usize))
                    .collect();
                for [x, y] in &origins {
                    assert!(x + resolution <= size.width && y + resolution <= size.height);
                    assert!(x % resolution == 0 && y % resolution == 0);
                }
                let count = origins.len();
                origins.sort_unstable();
                origins.dedup();
                assert_eq!(origins.len(), count);
                // As many hemicubes later, each is in its place again.
                assert_eq!(layout.origin(5 + tiles, 2), layout.origin(5, 2));
            }
        }
    }

    #[test]
    fn a_tile_beyond_the_largest_texture_is_refused() {
        assert_eq!(AtlasLayout::new(4096, 2048), None);
    }
}
