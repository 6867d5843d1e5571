//! The typeface in a PDF: the outlines of the letters that are shown, and which characters they stand for.

use std::collections::BTreeMap;

use pdf_writer::types::{CidFontType, FontFlags, SystemInfo, UnicodeCmap};
use pdf_writer::{Filter, Finish, Name, Pdf, Rect, Ref, Str};
use resvg::usvg;
use skrifa::instance::{LocationRef, Size};
use skrifa::{FontRef, GlyphId, MetadataProvider};
use subsetter::GlyphRemapper;

use super::super::type_metrics::FONT;
use super::stream::{deflated, refusal};
use overlook_engine::error::Result;

/// Lengths of a typeface in PDF count so many to an em.
const EM: f32 = 1000.0;

const NAME: Name<'static> = Name(b"OVRLKS+Ubuntu-Light");

const SYSTEM: SystemInfo<'static> =
    SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

/// The letters that are shown so far.
#[derive(Default)]
pub(super) struct Typeface {
    letters: GlyphRemapper,
    /// What each of them stands for, by its number in the PDF.
    texts: BTreeMap<u16, String>,
    units: Option<f32>,
}

impl Typeface {
    /// The number of a letter in the PDF.
    ///
    /// # Errors
    /// `Unsupported` where the typeface has more letters than a PDF can count.
    pub(super) fn glyph(&mut self, glyph: &usvg::layout::PositionedGlyph) -> Result<u16> {
        let id = u16::try_from(glyph.id.0).map_err(|_| refusal("letters of that typeface"))?;
        let number = self.letters.remap(id);
        self.texts.entry(number).or_insert_with(|| glyph.text.clone());
        Ok(number)
    }

    /// Units of the typeface's outlines to an em.
    pub(super) fn units(&mut self) -> f32 {
        let measured = || {
            let font = FontRef::new(FONT).ok()?;
            Some(f32::from(font.metrics(Size::unscaled(), LocationRef::default()).units_per_em))
        };
        *self.units.get_or_insert_with(|| measured().unwrap_or(EM))
    }

    /// Whether any letter is shown.
    pub(super) fn is_used(&self) -> bool {
        !self.texts.is_empty()
    }

    /// Writes the typeface with the letters that are shown.
    ///
    /// # Errors
    /// `Unsupported` where the typeface cannot be read.
    pub(super) fn write(&self, pdf: &mut Pdf, next: &mut Ref) -> Result<Ref> {
        let unreadable = || refusal("that typeface");
        let font = FontRef::new(FONT).map_err(|_| unreadable())?;
        let metrics = font.metrics(Size::new(EM), LocationRef::default());
        let advances = font.glyph_metrics(Size::new(EM), LocationRef::default());
        let widths: Vec<f32> = self
            .letters
            .remapped_gids()
            .map(|glyph| advances.advance_width(GlyphId::from(glyph)).unwrap_or(0.0))
            .collect();
        let file = subsetter::subset(FONT, 0, &self.letters).map_err(|_| unreadable())?;
        let [font_id, letters, descriptor, outlines, characters] = std::array::from_fn(|_| next.bump());
        let mut composite = pdf.type0_font(font_id);
        composite.base_font(NAME).encoding_predefined(Name(b"Identity-H"));
        composite.descendant_font(letters).to_unicode(characters);
        composite.finish();
        let mut described = pdf.cid_font(letters);
        described.subtype(CidFontType::Type2).base_font(NAME).system_info(SYSTEM).font_descriptor(descriptor);
        described.default_width(0.0).cid_to_gid_map_predefined(Name(b"Identity"));
        described.widths().consecutive(0, widths);
        described.finish();
        let bounds = metrics.bounds.unwrap_or_default();
        let mut description = pdf.font_descriptor(descriptor);
        description.name(NAME).flags(FontFlags::SYMBOLIC).italic_angle(0.0).stem_v(70.0).font_file2(outlines);
        description.bbox(Rect::new(bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max));
        description.ascent(metrics.ascent).descent(metrics.descent);
        description.cap_height(metrics.cap_height.unwrap_or(metrics.ascent));
        description.finish();
        let compressed = deflated(&file)?;
        pdf.stream(outlines, &compressed)
            .filter(Filter::FlateDecode)
            .pair(Name(b"Length1"), i32::try_from(file.len()).unwrap_or(i32::MAX));
        let mut map = UnicodeCmap::new(Name(b"Characters"), SYSTEM);
        for (number, text) in &self.texts {
            map.pair_with_multiple(*number, text.chars());
        }
        pdf.cmap(characters, &map.finish());
        Ok(font_id)
    }
}
