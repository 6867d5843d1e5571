//! Memory for samples on the adapter: images are uploaded once, and the least recently used are evicted.
//!
//! Shaders see at most four pages, none longer than a binding may be (128 MiB on some adapters). An image that fits into no
//! page is cut between tiles into pieces. Pages begin at twice the size of the first frame's samples; when all four are full,
//! they are replaced by pages of full size.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use super::context::Context;
use super::layout::GpuPiece;
use super::upload::Piece;
use crate::error::{Error, Result};
use crate::samples::SampleImage;

/// Pages that shaders can see at once.
pub(super) const MAX_PAGES: usize = 4;

/// The smallest page, bytes.
const MIN_PAGE: u64 = 16 << 20;

#[derive(Debug)]
struct Page {
    buffer: wgpu::Buffer,
    space: PageAllocator,
}

/// Which words of a page are in use.
#[derive(Debug)]
struct PageAllocator {
    words: u32,
    /// The pieces, ascending: first word and number of words.
    used: Vec<(u32, u32)>,
}

impl PageAllocator {
    fn new(words: u32) -> Self {
        Self { words, used: Vec::new() }
    }

    /// Allocates the first gap of `words`; returns its first word.
    fn allocate(&mut self, words: u32) -> Option<u32> {
        let mut end = 0;
        let mut place = self.used.len();
        for (index, &(start, length)) in self.used.iter().enumerate() {
            if start - end >= words {
                place = index;
                break;
            }
            end = start + length;
        }
        if place == self.used.len() && self.words - end < words {
            return None;
        }
        self.used.insert(place, (end, words));
        Some(end)
    }

    fn free(&mut self, start: u32) {
        self.used.retain(|(used, _)| *used != start);
    }
}

/// An image on the adapter.
#[derive(Debug)]
struct ResidentImage {
    /// Weak: reserves the image's address, the key of the map, but does not keep its samples in main memory.
    image: Weak<SampleImage>,
    pieces: Vec<GpuPiece>,
    last_used: u64,
}

impl ResidentImage {
    /// Whether the image was dropped.
    fn is_dropped(&self) -> bool {
        self.image.strong_count() == 0
    }
}

/// The pages and the images in them.
#[derive(Debug)]
pub(super) struct SampleMemory {
    pages: Vec<Page>,
    page_bytes: u64,
    max_page_bytes: u64,
    resident: HashMap<usize, ResidentImage>,
    now: u64,
    /// Bytes uploaded so far.
    pub(super) uploaded: u64,
}

impl SampleMemory {
    /// Memory of at most `budget` bytes.
    pub(super) fn new(context: &Context, budget: u64) -> Self {
        let max_page_bytes = (budget / MAX_PAGES as u64).clamp(1 << 12, 1 << 31).min(context.max_binding());
        Self {
            pages: Vec::new(),
            page_bytes: 0,
            max_page_bytes,
            resident: HashMap::new(),
            now: 0,
            uploaded: 0,
        }
    }

    /// The pages' buffers.
    pub(super) fn pages(&self) -> impl Iterator<Item = &wgpu::Buffer> {
        self.pages.iter().map(|page| &page.buffer)
    }

    /// Uploads the images of a frame, if they are not resident, and returns the pieces of each.
    ///
    /// # Errors
    /// `Gpu` where they do not fit.
    pub(super) fn load(
        &mut self,
        context: &Context,
        images: &[&Arc<SampleImage>],
    ) -> Result<Vec<Vec<GpuPiece>>> {
        self.now += 1;
        if self.page_bytes == 0 {
            let bytes = images.iter().map(|image| image.bytes() as u64).sum::<u64>();
            self.page_bytes = (2 * bytes).next_multiple_of(1 << 20).max(MIN_PAGE).min(self.max_page_bytes);
        }
        if let Some(placed) = self.try_load(context, images)? {
            return Ok(placed);
        }
        self.resident.clear();
        if self.page_bytes < self.max_page_bytes {
            self.page_bytes = self.max_page_bytes;
            self.pages.clear();
        }
        // There may be enough space in all, but in gaps between images that this frame needs too.
        for page in &mut self.pages {
            page.space = PageAllocator::new((self.page_bytes / 4) as u32);
        }
        self.try_load(context, images)?.ok_or_else(|| Error::Gpu {
            what: format!(
                "the samples of one frame do not fit into {} MiB on {}; use the CPU instead",
                (MAX_PAGES as u64 * self.max_page_bytes) >> 20,
                context.adapter.name
            ),
        })
    }

    /// Drops everything, after a failure that may have left pages unusable.
    pub(super) fn forget(&mut self) {
        self.resident.clear();
        self.pages.clear();
        self.page_bytes = 0;
    }

    /// Uploads images while there is space, without evicting those that `load` has just used.
    pub(super) fn prefetch(&mut self, context: &Context, images: &[&Arc<SampleImage>]) -> Result<()> {
        if self.page_bytes > 0 {
            self.try_load(context, images)?;
            context.queue.submit([]);
        }
        Ok(())
    }

    fn try_load(
        &mut self,
        context: &Context,
        images: &[&Arc<SampleImage>],
    ) -> Result<Option<Vec<Vec<GpuPiece>>>> {
        // Those that are resident already must not be evicted for the others.
        for image in images {
            if let Some(resident) = self.resident.get_mut(&Arc::as_ptr(image).addr()) {
                resident.last_used = self.now;
            }
        }
        let mut all = Vec::with_capacity(images.len());
        for image in images {
            if !self.make_resident(context, image)? {
                return Ok(None);
            }
            all.push(self.resident[&Arc::as_ptr(image).addr()].pieces.clone());
        }
        Ok(Some(all))
    }

    /// Uploads an image; `false` if there is no space.
    fn make_resident(&mut self, context: &Context, image: &Arc<SampleImage>) -> Result<bool> {
        let address = Arc::as_ptr(image).addr();
        if self.resident.contains_key(&address) {
            return Ok(true);
        }
        let mut pieces: Vec<GpuPiece> = Vec::new();
        for piece in Piece::cut(image, (self.page_bytes / 4) as u32) {
            let Some((page, at)) = self.place(context, piece.words())? else {
                self.free(&pieces);
                return Ok(false);
            };
            let placed = piece.place(page, at);
            piece.write(image, &context.queue, &self.pages[page as usize].buffer, &placed);
            self.uploaded += u64::from(piece.words()) * 4;
            pieces.push(placed);
        }
        self.resident
            .insert(address, ResidentImage { image: Arc::downgrade(image), pieces, last_used: self.now });
        Ok(true)
    }

    /// Page and first word of a gap of `words`, after evicting images if needed.
    fn place(&mut self, context: &Context, words: u32) -> Result<Option<(u32, u32)>> {
        loop {
            for (index, page) in self.pages.iter_mut().enumerate() {
                if let Some(at) = page.space.allocate(words) {
                    return Ok(Some((index as u32, at)));
                }
            }
            if self.pages.len() < MAX_PAGES {
                let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
                let buffer = context.buffer("samples", self.page_bytes, usage)?;
                self.pages.push(Page { buffer, space: PageAllocator::new((self.page_bytes / 4) as u32) });
            } else if !self.evict() {
                return Ok(None);
            }
        }
    }

    fn free(&mut self, pieces: &[GpuPiece]) {
        for piece in pieces {
            self.pages[piece.page as usize].space.free(piece.tiles_at);
        }
    }

    /// Evicts an image that was dropped, else the least recently used one. `false` if this frame needs all.
    fn evict(&mut self) -> bool {
        let idle = self.resident.iter().filter(|(_, image)| image.is_dropped() || image.last_used < self.now);
        let oldest = idle.min_by_key(|(_, image)| (!image.is_dropped(), image.last_used));
        let Some((&address, _)) = oldest else { return false };
        if let Some(oldest) = self.resident.remove(&address) {
            self.free(&oldest.pieces);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::gpu::context::AdapterChoice;
    use crate::render::gpu::opened;
    use crate::samples::{DepthPlane, SampleTile, Span, TILE, TILE_SAMPLES};
    use half::f16;

    /// An image of full tiles.
    fn image(tiles: usize) -> Arc<SampleImage> {
        let tiles: Vec<_> = (0..tiles)
            .map(|nth| SampleTile {
                tile_x: nth as u16,
                tile_y: 0,
                first: (nth * TILE_SAMPLES) as u32,
                rows: [u16::MAX; TILE],
            })
            .collect();
        let count = tiles.len() * TILE_SAMPLES;
        Arc::new(SampleImage {
            camera: 0,
            span: Span { start: 0, end: 1 },
            color: vec![[f16::ONE; 3]; count],
            depth: DepthPlane::pack(&tiles, &vec![0.5; count]),
            tiles,
            normal: None,
            doubtful: Vec::new(),
            values: crate::capture::Values::default(),
        })
    }

    /// An adapter and memory on it of four pages, of as many full tiles each.
    fn memory(tiles_to_a_page: u64) -> Option<(Context, SampleMemory)> {
        let context = opened(Context::new(AdapterChoice::Any))?;
        let tile = 4 * u64::from(Piece::cut(&image(1), u32::MAX)[0].words());
        let memory = SampleMemory::new(&context, MAX_PAGES as u64 * tiles_to_a_page * tile);
        Some((context, memory))
    }

    fn load(context: &Context, memory: &mut SampleMemory, images: &[Arc<SampleImage>]) -> Result<()> {
        let images: Vec<_> = images.iter().collect();
        context.guarded(|| memory.load(context, &images)).map(drop)
    }

    #[test]
    fn a_frame_that_fits_is_loaded_though_images_it_shares_with_the_one_before_lie_scattered() {
        let Some((context, mut memory)) = memory(4) else { return };
        let small: Vec<_> = (0..16).map(|_| image(1)).collect();
        load(&context, &mut memory, &small).unwrap();
        let next: Vec<_> = small.iter().step_by(2).cloned().chain((0..4).map(|_| image(2))).collect();
        load(&context, &mut memory, &next).unwrap();
        let full: Vec<_> = next.into_iter().chain([image(1)]).collect();
        assert!(load(&context, &mut memory, &full).unwrap_err().to_string().contains("do not fit"));
    }

    #[test]
    fn what_lies_on_the_adapter_is_not_kept_in_main_memory_too() {
        let Some((context, mut memory)) = memory(1) else { return };
        let images = [image(1), image(1), image(1), image(1)];
        load(&context, &mut memory, &images).unwrap();
        let [gone, .., kept] = images;
        let samples = Arc::downgrade(&gone);
        drop(gone);
        assert!(samples.upgrade().is_none());
        // Its space is reused before that of an image that still exists.
        load(&context, &mut memory, &[image(1)]).unwrap();
        let sent = memory.uploaded;
        load(&context, &mut memory, &[kept]).unwrap();
        assert_eq!(memory.uploaded, sent);
    }

    #[test]
    fn room_that_was_given_back_is_taken_again_and_never_twice() {
        let mut room = PageAllocator::new(100);
        assert_eq!([40, 30, 20].map(|words| room.allocate(words)), [Some(0), Some(40), Some(70)]);
        assert_eq!((room.allocate(11), room.allocate(10)), (None, Some(90)));
        room.free(40);
        assert_eq!((room.allocate(31), room.allocate(25), room.allocate(6)), (None, Some(40), None));
        assert_eq!(room.allocate(5), Some(65));
        room.free(0);
        assert_eq!((room.allocate(41), room.allocate(40), room.allocate(1)), (None, Some(0), None));
    }
}
