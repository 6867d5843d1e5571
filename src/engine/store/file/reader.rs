//! Reads a store image by image.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::chunks::{InfoChunks, decode_doubtful, from_iff, in_chunk, is_known};
use super::header::{ImageEntry, chain};
use super::info::StoreInfo;
use super::value_chunks::ValueTable;
use super::verdict_chunk::{VerdictEntry, VerdictTable};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::{DepthPlane, PixelVerdict, SampleImage, SampleSet, Span};
use crate::store::codec::{BLOCK, BlockVerdicts, FrequencyTables};
use crate::store::container::{
    ChunkHeader, ChunkId, DOUBTFUL, FORM_HEADER, FormReader, IMAGE, IMAGE_VALUES, MODEL, PALETTE, ReadAt,
    STORE, VALUES, VERDICTS,
};
use crate::store::image::{
    self, BlockCoding, BlockEntry, ColorRanks, Damage, Decoded, DoubtfulRuns, ImageHead, ImageValues,
    ReferenceImage, ValueCodes, VisibleBlocks,
};
use crate::whole_file;

/// An open store, from which images are read one by one. Reading from several threads is fine.
pub struct Store {
    path: PathBuf,
    info: StoreInfo,
    model: FrequencyTables,
    palette: ColorRanks,
    /// Runs of images that have doubtful samples.
    doubtful: BTreeMap<usize, DoubtfulRuns>,
    /// Scalar values, where there are any.
    values: Option<ValueTable>,
    /// The chunk of verdicts with its table, or why it cannot be read; `None` where the store has none.
    verdicts: Option<(ChunkHeader, std::result::Result<VerdictTable, String>)>,
    form: FormReader<Box<dyn ReadAt>>,
    /// What could not be read so far, by image.
    damage: Mutex<BTreeMap<usize, Vec<String>>>,
    blocks_read: AtomicU64,
}

impl Store {
    /// Whether the file at `path` is an IFF file, as every store is, by its first four bytes.
    ///
    /// # Errors
    /// `Io` where it cannot be read.
    pub fn is_store(path: &Path) -> Result<bool> {
        if path.is_dir() {
            return Ok(false);
        }
        let mut start = [0; 4];
        let mut file = whole_file::open(path)?;
        Ok(file.read_exact(&mut start).is_ok() && start == *b"FORM")
    }

    /// Reads everything but the images.
    ///
    /// # Errors
    /// `Io`, `Invalid` (naming file, byte offset and chunk), `Unsupported` (a newer version).
    pub fn open(path: &Path) -> Result<Self> {
        let file = whole_file::open(path)?;
        let is_folder = file.metadata().is_ok_and(|metadata| metadata.is_dir());
        if is_folder {
            let place = path.display();
            let what = format!(
                "is a folder, not a store; make one of a capture with overlook preprocess {place} --out scene.ovl"
            );
            return Err(Error::invalid(&place, what));
        }
        Self::over(path, Box::new(file))
    }

    /// As [`Store::open`], over bytes from elsewhere; `path` is named in errors.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub fn over(path: &Path, source: Box<dyn ReadAt>) -> Result<Self> {
        let form = FormReader::open(source, STORE).map_err(|error| from_iff(path, error))?;
        let chunks = InfoChunks::collect(&form, path)?;
        let mut info = StoreInfo::decode(&chunks, form.size(), path)?;
        let palette =
            ColorRanks::decode(chunks.get(PALETTE)).map_err(|what| in_chunk(path, PALETTE, what))?;
        let model = FrequencyTables::decode(chunks.get(MODEL)).map_err(|what| in_chunk(path, MODEL, what))?;
        let doubtful = decode_doubtful(chunks.get(DOUBTFUL), &info.images, &info.cameras)
            .map_err(|what| in_chunk(path, DOUBTFUL, what))?;
        let values = Some(chunks.get(VALUES)).filter(|payload| !payload.is_empty());
        let values = values.map(|payload| ValueTable::decode(payload, info.images.len())).transpose();
        let values = values.map_err(|what| in_chunk(path, VALUES, what))?;
        info.values = values.as_ref().map_or_else(Vec::new, |table| table.stored.clone());
        let verdicts = chunks.verdicts.map(|header| {
            let bytes = |range| form.plain_payload(&header, range).map_err(|error| from_iff(path, error));
            let frames = info.frame_numbers.len();
            (header, VerdictTable::read(header.length, info.cameras.len(), frames, bytes))
        });
        Ok(Self {
            path: path.to_path_buf(),
            values,
            verdicts,
            doubtful,
            info,
            model,
            palette,
            form,
            damage: Mutex::default(),
            blocks_read: AtomicU64::new(0),
        })
    }

    /// Where it was opened.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What is known of the store without its images.
    #[must_use]
    pub fn info(&self) -> &StoreInfo {
        &self.info
    }

    /// Blocks of 64×64 pixels that were decoded so far.
    #[must_use]
    pub fn blocks_read(&self) -> u64 {
        self.blocks_read.load(Relaxed)
    }

    /// What could not be read of the images so far, one line each.
    #[must_use]
    pub fn damage(&self) -> Vec<String> {
        let damage = self.damage.lock().unwrap_or_else(PoisonError::into_inner);
        damage.values().flatten().cloned().collect()
    }

    /// Reads one image, by its place in [`StoreInfo::images`], and those it is predicted from; the others are not touched.
    /// Tiles that are damaged are missing in it: see [`Store::damage`].
    ///
    /// # Errors
    /// `Io`; `Invalid` where there is no such image.
    pub fn image(&self, index: usize) -> Result<SampleImage> {
        let chain = chain(&self.info.images, index).ok_or_else(|| {
            let count = self.info.images.len();
            Error::invalid(self.path.display(), format!("there is no image {index}; there are {count}"))
        })?;
        let mut before = None;
        for index in chain.into_iter().rev() {
            before = Some(self.decode(index, None, before.as_ref(), None)?);
        }
        let image = before.map(|decoded| Arc::unwrap_or_clone(decoded.image));
        image.ok_or_else(|| self.damaged(index, "there is no image"))
    }

    /// Reads the visible blocks of an image, or all, given what was read `so_far` and the image that it is predicted from, with the same
    /// blocks read.
    pub(crate) fn decode(
        &self,
        index: usize,
        so_far: Option<&Decoded>,
        before: Option<&Decoded>,
        visible: Option<&VisibleBlocks>,
    ) -> Result<Decoded> {
        let decoded = match so_far {
            Some(so_far) => Ok(so_far.clone()),
            None => self.undecoded(index),
        };
        match decoded.and_then(|decoded| self.decode_missing(index, decoded, before, visible)) {
            Err(Error::Invalid { what, .. }) => {
                self.record_damage(
                    index,
                    vec![format!("{}: nothing of it can be shown", self.damaged(index, &what))],
                );
                let image = Arc::new(self.placeholder(index));
                Ok(Decoded { image, head: None, read: Vec::new(), damage: Vec::new() })
            }
            decoded => decoded,
        }
    }

    /// An image with only its head read.
    fn undecoded(&self, index: usize) -> Result<Decoded> {
        let head = self.head(index)?;
        Ok(Decoded {
            image: Arc::new(self.placeholder(index)),
            read: vec![false; head.blocks.len()],
            head: Some(Arc::new(head)),
            damage: Vec::new(),
        })
    }

    fn decode_missing(
        &self,
        index: usize,
        mut decoded: Decoded,
        before: Option<&Decoded>,
        visible: Option<&VisibleBlocks>,
    ) -> Result<Decoded> {
        let Some(head) = decoded.head.clone() else { return Ok(decoded) };
        let missing = decoded.missing(visible);
        let (Some(first), Some(last)) = (missing.first(), missing.last()) else { return Ok(decoded) };
        if before.is_some_and(|before| before.head.is_none()) {
            return Err(self.damaged(index, "the image it is predicted from is lost"));
        }
        let unlike =
            |other: &ImageHead| (other.normals, other.depth_shift) != (head.normals, head.depth_shift);
        if before.and_then(|before| before.head.as_deref()).is_some_and(unlike) {
            return Err(self.damaged(index, "it is coded otherwise than the image it is predicted from"));
        }
        let from = first.start;
        let range = from as u64..(last.start + last.length) as u64;
        let codes = self.bytes(&self.chunk(index)?, range)?;
        let code = |block: &BlockEntry| {
            let code = codes.get(block.start - from..).and_then(|rest| rest.get(..block.length));
            code.ok_or("it is cut short".to_owned())
        };
        let reference = before.map(|before| ReferenceImage { image: &before.image, damage: &before.damage });
        let coding = self.coding(&self.info.images[index], &head);
        let payload = self.values_payload(index);
        let values = self.values.as_ref().map(|table| {
            let codes = payload.as_deref().map_err(Error::to_string);
            let codes = codes.and_then(|payload| ValueCodes::of(payload, head.blocks.len()));
            ImageValues { coding: &table.coding, codes }
        });
        let (mut image, damage) =
            image::decode(&decoded.image, &head, reference, &coding, values.as_ref(), code, &missing);
        if let Some(runs) = self.doubtful.get(&index) {
            image.doubtful = runs.masks(&image.tiles, coding.size.0);
        }
        debug_assert_eq!(image::check(&image, &self.info.cameras, self.info.frame_numbers.len()), Ok(()));
        self.blocks_read.fetch_add(missing.len() as u64, Relaxed);
        decoded.image = Arc::new(image);
        decoded.damage.extend(damage);
        let wanted = |block: &BlockEntry| visible.is_none_or(|visible| visible.has(block.place));
        head.blocks.iter().zip(&mut decoded.read).for_each(|(block, read)| *read |= wanted(block));
        self.record_damage(
            index,
            decoded.damage.iter().map(|damage| self.damaged_block(index, damage)).collect(),
        );
        Ok(decoded)
    }

    fn coding(&self, entry: &ImageEntry, head: &ImageHead) -> BlockCoding<'_> {
        BlockCoding {
            model: &self.model,
            palette: &self.palette,
            depth_shift: head.depth_shift,
            normals: head.normals,
            plain: head.plain,
            size: self.info.cameras[entry.camera as usize].intrinsics.size(),
        }
    }

    /// The chunk of an image.
    fn chunk(&self, index: usize) -> Result<ChunkHeader> {
        let entry = &self.info.images[index];
        let header = self.form.header_at(entry.offset).map_err(|error| from_iff(&self.path, error))?;
        let header = header.filter(|header| header.id == IMAGE && header.length == u64::from(entry.length));
        header.ok_or_else(|| self.damaged(index, "there is no image of the length in the index"))
    }

    /// The payload of an image's scalar values; empty where the store has none.
    fn values_payload(&self, index: usize) -> Result<Vec<u8>> {
        let Some((offset, length)) = self.values.as_ref().map(|table| table.places[index]) else {
            return Ok(Vec::new());
        };
        let header = self.form.header_at(offset).map_err(|error| from_iff(&self.path, error))?;
        let is_stated =
            |header: &ChunkHeader| header.id == IMAGE_VALUES && header.length == u64::from(length);
        let header = header.filter(is_stated);
        let header = header.ok_or_else(|| self.damaged(index, "its values are not where they should be"))?;
        self.bytes(&header, 0..u64::from(length))
    }

    fn bytes(&self, chunk: &ChunkHeader, range: std::ops::Range<u64>) -> Result<Vec<u8>> {
        self.form.plain_payload(chunk, range).map_err(|error| from_iff(&self.path, error))
    }

    /// Where the blocks of an image are and between which depths, without any sample of them.
    ///
    /// # Errors
    /// `Io`; `Invalid` where there is no such image and where its head is damaged.
    pub fn head(&self, index: usize) -> Result<ImageHead> {
        let entry = self
            .info
            .images
            .get(index)
            .ok_or_else(|| Error::invalid(self.path.display(), format!("there is no image {index}")))?;
        let bytes = self.bytes(&self.chunk(index)?, 0..u64::from(entry.head))?;
        let camera = &self.info.cameras[entry.camera as usize];
        let head = image::decode_head(&bytes, entry.length as usize, camera)
            .map_err(|what| self.damaged(index, &what))?;
        let samples: u64 = head.blocks.iter().map(|block| u64::from(block.samples)).sum();
        let tiles: u32 = head.blocks.iter().map(|block| block.tiles.count_ones()).sum();
        if (samples, tiles) != (u64::from(entry.samples), entry.tiles) {
            return Err(self.damaged(index, "it differs from the index"));
        }
        Ok(head)
    }

    /// An image of the right camera and span without any sample.
    fn placeholder(&self, index: usize) -> SampleImage {
        let entry = &self.info.images[index];
        SampleImage {
            camera: entry.camera,
            span: entry.span,
            tiles: Vec::new(),
            color: Vec::new(),
            depth: DepthPlane::default(),
            normal: None,
            doubtful: Vec::new(),
            values: crate::capture::Values::default(),
        }
    }

    fn record_damage(&self, index: usize, damage: Vec<String>) {
        if !damage.is_empty() {
            self.damage.lock().unwrap_or_else(PoisonError::into_inner).insert(index, damage);
        }
    }

    fn place(&self, index: usize) -> String {
        let entry = &self.info.images[index];
        let frames = &self.info.frame_numbers;
        let (first, last) = (frames[entry.span.start as usize], frames[entry.span.end as usize - 1]);
        format!(
            "{}: at byte {}: chunk 'IMAG' of camera '{}', frames {first} to {last}",
            self.path.display(),
            entry.offset,
            self.info.cameras[entry.camera as usize].name
        )
    }

    fn damaged(&self, index: usize, what: &str) -> Error {
        Error::invalid(self.place(index), what)
    }

    fn damaged_block(&self, index: usize, Damage { place: (x, y), what }: &Damage) -> String {
        let (left, top) = (u32::from(*x) * 64, u32::from(*y) * 64);
        format!("{}: the 64×64 pixels from ({left}, {top}) are missing: {what}", self.place(index))
    }

    /// A set with every image in its place and no sample in any.
    pub(crate) fn outline(&self) -> SampleSet {
        let placeholders = (0..self.info.images.len()).map(|index| Arc::new(self.placeholder(index)));
        SampleSet {
            name: self.info.name.clone(),
            cameras: self.info.cameras.clone(),
            frame_numbers: self.info.frame_numbers.clone(),
            up_in_world: self.info.up_in_world,
            settings: self.info.settings.clone(),
            images: placeholders.collect(),
            values: self.info.values.iter().map(|stored| stored.channel.clone()).collect(),
        }
    }

    /// The headers of all chunks in their order; an error ends them.
    fn chunk_headers(&self) -> impl Iterator<Item = Result<ChunkHeader>> {
        let mut offset = Some(FORM_HEADER);
        std::iter::from_fn(move || {
            let header = self.form.header_at(offset?).transpose()?;
            offset = header.as_ref().ok().map(ChunkHeader::end);
            Some(header.map_err(|error| from_iff(&self.path, error)))
        })
    }

    /// Chunks that this Overlook does not know, for writing the store again: id and payload as it is.
    ///
    /// # Errors
    /// `Io`; `Invalid` where the chunks do not follow one another to the end of the file.
    pub fn unknown_chunks(&self) -> Result<Vec<(ChunkId, Vec<u8>)>> {
        let mut unknown = Vec::new();
        for header in self.chunk_headers() {
            let header = header?;
            if ![IMAGE, IMAGE_VALUES].contains(&header.id) && !is_known(header.id) {
                unknown.push((header.id, self.bytes(&header, 0..header.length)?));
            }
        }
        Ok(unknown)
    }

    /// Checks that chunks follow one another to the end of the file and that the index has every image; gives what is damaged.
    pub(crate) fn check_chunks(&self) -> Result<Vec<String>> {
        let mut damage = Vec::new();
        for header in self.chunk_headers() {
            match header {
                Ok(ChunkHeader { id, offset, .. }) => {
                    let images = &self.info.images;
                    if id == IMAGE && images.binary_search_by_key(&offset, |image| image.offset).is_err() {
                        let path = self.path.display();
                        damage.push(format!("{path}: at byte {offset}: chunk 'IMAG' is not in the index"));
                    }
                }
                Err(error @ Error::Io { .. }) => return Err(error),
                Err(error) => damage.push(error.to_string()),
            }
        }
        Ok(damage)
    }
}

/// What became of pixels: none of these is an image.
impl Store {
    /// Whether it says what became of every pixel.
    #[must_use]
    pub fn has_verdicts(&self) -> bool {
        matches!(self.verdicts, Some((_, Ok(_))))
    }

    /// What became of a pixel of a camera at a frame: the span of its sample, kept or not, and the verdict on it; `None` where it has none,
    /// and where the store says nothing of it. Only the block around the pixel is decoded.
    ///
    /// # Errors
    /// `Io`; `Invalid` where that is damaged.
    pub fn verdict_at(
        &self,
        frame: usize,
        camera: usize,
        (x, y): (usize, usize),
    ) -> Result<Option<(Span, PixelVerdict)>> {
        let block = (x / BLOCK, y / BLOCK);
        let mut found = None;
        self.each_verdict_block(
            frame,
            camera,
            |at| at == block,
            |span, (left, top), verdicts| {
                let (rule, witness) = verdicts.get(x - left, y - top);
                let verdict = PixelVerdict { rule, witness };
                found = found.or((verdict != PixelVerdict::NONE).then_some((span, verdict)));
            },
        )?;
        Ok(found)
    }

    /// Visits every pixel of a camera that has a sample at a frame, kept or not: its column and row, the span of the sample, and the
    /// verdict on it.
    ///
    /// # Errors
    /// As [`Store::verdict_at`].
    pub fn each_verdict(
        &self,
        frame: usize,
        camera: usize,
        mut visit: impl FnMut((usize, usize), Span, PixelVerdict),
    ) -> Result<()> {
        self.each_verdict_block(
            frame,
            camera,
            |_| true,
            |span, (left, top), verdicts| {
                for (x, y) in (0..BLOCK).flat_map(|y| (0..BLOCK).map(move |x| (x, y))) {
                    let (rule, witness) = verdicts.get(x, y);
                    let verdict = PixelVerdict { rule, witness };
                    if verdict != PixelVerdict::NONE {
                        visit((left + x, top + y), span, verdict);
                    }
                }
            },
        )
    }

    fn each_verdict_block(
        &self,
        frame: usize,
        camera: usize,
        wanted: impl Fn((usize, usize)) -> bool,
        mut visit: impl FnMut(Span, (usize, usize), &BlockVerdicts),
    ) -> Result<()> {
        let is_asked = |entry: &VerdictEntry| entry.camera as usize == camera && entry.span.contains(frame);
        self.decode_verdicts(is_asked, wanted, &mut visit)
    }

    /// Decodes all verdicts.
    ///
    /// # Errors
    /// As [`Store::verdict_at`].
    pub(crate) fn check_verdicts(&self) -> Result<()> {
        self.decode_verdicts(|_| true, |_| true, |_, _, _| {})
    }

    fn decode_verdicts(
        &self,
        is_asked: impl Fn(&VerdictEntry) -> bool,
        wanted: impl Fn((usize, usize)) -> bool,
        mut visit: impl FnMut(Span, (usize, usize), &BlockVerdicts),
    ) -> Result<()> {
        let Some((header, table)) = &self.verdicts else { return Ok(()) };
        let table = table.as_ref().map_err(|what| in_chunk(&self.path, VERDICTS, what))?;
        for entry in table.entries.iter().filter(|entry| is_asked(entry)) {
            let size = self.info.cameras[entry.camera as usize].intrinsics.size();
            let bytes = self.bytes(header, entry.range())?;
            let decoded = table.decode_span(&bytes, size, self.info.cameras.len(), &wanted, |at, block| {
                visit(entry.span, at, block);
            });
            decoded.map_err(|what| in_chunk(&self.path, VERDICTS, what))?;
        }
        Ok(())
    }
}

impl Store {
    /// Reads every image. Tiles that are damaged are missing: see [`Store::damage`].
    ///
    /// # Errors
    /// `Io` and `Cancelled`.
    pub fn read_all(&self, job: &Job) -> Result<SampleSet> {
        let count = self.info().images.len();
        job.start("Reading the store", count);
        let depths: Vec<usize> = (0..count)
            .map(|index| chain(&self.info().images, index).map_or(0, |chain| chain.len() - 1))
            .collect();
        let mut decoded: Vec<Option<Decoded>> = vec![None; count];
        // First images that need no other, then images that need one of these, and so on.
        for depth in 0..=depths.iter().copied().max().unwrap_or(0) {
            let ready: Vec<usize> = (0..count).filter(|index| depths[*index] == depth).collect();
            let read = ready.par_iter().map(|&index| {
                job.check()?;
                let before =
                    self.info().images[index].reference.and_then(|before| decoded[before as usize].as_ref());
                let image = self.decode(index, None, before, None)?;
                job.advance(1);
                Ok(image)
            });
            let read: Result<Vec<Decoded>> = read.collect();
            for (index, image) in ready.into_iter().zip(read?) {
                decoded[index] = Some(image);
            }
        }
        let mut samples = self.outline();
        let images = decoded.into_iter().flatten().map(|decoded| decoded.image);
        samples.images = images.filter(|image| !image.is_empty()).collect();
        Ok(samples)
    }

    /// As [`Store::read_all`], where nothing may be damaged.
    ///
    /// # Errors
    /// `Io`, `Invalid` naming what is damaged, `Cancelled`.
    pub fn read_undamaged(&self, job: &Job) -> Result<SampleSet> {
        let read = self.read_all(job)?;
        match self.damage().first() {
            None => Ok(read),
            Some(damage) => Err(Error::invalid(self.path().display(), damage)),
        }
    }
}
