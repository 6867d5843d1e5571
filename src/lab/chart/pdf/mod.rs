//! A chart as PDF: the tree of its SVG, shape by shape. Shapes stay shapes, text stays text.
//!
//! Source: ISO 32000-1 (PDF 1.7), sections 8 and 9. What differs from a converter of any SVG: only what charts and figures hold is
//! written, which is fills and strokes of one color, text and PNG pictures; all else is refused rather than left out.

mod stream;
mod typeface;

use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use resvg::tiny_skia::PathSegment;
use resvg::usvg;
use usvg::{Fill, FillRule, Group, ImageKind, LineCap, LineJoin, Node, Paint, Stroke, Transform};

use overlook_engine::error::Result;
use stream::{deflated, refusal};
use typeface::Typeface;

/// Typographic points of a pixel of SVG.
const POINTS_PER_PIXEL: f32 = 0.75;

/// The tree as a PDF of one page of its size.
///
/// # Errors
/// `Unsupported` where it holds what no chart has, with its name.
pub(super) fn of_tree(tree: &usvg::Tree) -> Result<Vec<u8>> {
    let mut writer = Writer {
        content: Content::new(),
        pictures: Vec::new(),
        shares: Vec::new(),
        typeface: Typeface::default(),
    };
    let [width, height] = [tree.size().width(), tree.size().height()].map(|side| side * POINTS_PER_PIXEL);
    writer.content.save_state();
    // Rows of SVG go down, those of PDF up.
    writer.content.transform([POINTS_PER_PIXEL, 0.0, 0.0, -POINTS_PER_PIXEL, 0.0, height]);
    writer.group(tree.root())?;
    writer.content.restore_state();
    writer.finish([width, height])
}

/// A page under way.
struct Writer {
    content: Content,
    /// As PNG.
    pictures: Vec<Vec<u8>>,
    /// Opacities other than 1, as they were met: of each the bits.
    shares: Vec<u32>,
    typeface: Typeface,
}

impl Writer {
    fn group(&mut self, group: &Group) -> Result<()> {
        let is_plain = group.clip_path().is_none()
            && group.mask().is_none()
            && group.filters().is_empty()
            && group.opacity().get() >= 1.0;
        if !is_plain {
            return Err(refusal("clipped, masked, filtered or transparent groups"));
        }
        self.content.save_state().transform(numbers(group.transform()));
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group)?,
                Node::Path(path) => self.path(path)?,
                Node::Image(image) => self.picture(image)?,
                Node::Text(text) => self.text(text)?,
            }
        }
        self.content.restore_state();
        Ok(())
    }

    fn path(&mut self, path: &usvg::Path) -> Result<()> {
        if !path.is_visible() {
            return Ok(());
        }
        if let Some(fill) = path.fill() {
            self.fill(fill)?;
            self.outline(path.data());
            match fill.rule() {
                FillRule::NonZero => self.content.fill_nonzero(),
                FillRule::EvenOdd => self.content.fill_even_odd(),
            };
        }
        if let Some(stroke) = path.stroke() {
            self.stroke(stroke)?;
            self.outline(path.data());
            self.content.stroke();
        }
        Ok(())
    }

    fn outline(&mut self, path: &resvg::tiny_skia::Path) {
        let mut at = resvg::tiny_skia::Point::zero();
        for segment in path.segments() {
            match segment {
                PathSegment::MoveTo(to) => {
                    self.content.move_to(to.x, to.y);
                    at = to;
                }
                PathSegment::LineTo(to) => {
                    self.content.line_to(to.x, to.y);
                    at = to;
                }
                PathSegment::QuadTo(control, to) => {
                    // The same curve as a cubic one.
                    let toward = |end: f32, control: f32| end + (control - end) * 2.0 / 3.0;
                    self.content.cubic_to(
                        toward(at.x, control.x),
                        toward(at.y, control.y),
                        toward(to.x, control.x),
                        toward(to.y, control.y),
                        to.x,
                        to.y,
                    );
                    at = to;
                }
                PathSegment::CubicTo(first, second, to) => {
                    self.content.cubic_to(first.x, first.y, second.x, second.y, to.x, to.y);
                    at = to;
                }
                PathSegment::Close => {
                    self.content.close_path();
                }
            }
        }
    }

    fn fill(&mut self, fill: &Fill) -> Result<()> {
        let [red, green, blue] = color(fill.paint())?;
        self.content.set_fill_rgb(red, green, blue);
        self.opacity(fill.opacity().get());
        Ok(())
    }

    fn stroke(&mut self, stroke: &Stroke) -> Result<()> {
        let [red, green, blue] = color(stroke.paint())?;
        self.content.set_stroke_rgb(red, green, blue).set_line_width(stroke.width().get());
        self.content.set_line_cap(match stroke.linecap() {
            LineCap::Butt => LineCapStyle::ButtCap,
            LineCap::Round => LineCapStyle::RoundCap,
            LineCap::Square => LineCapStyle::ProjectingSquareCap,
        });
        self.content.set_line_join(match stroke.linejoin() {
            LineJoin::Miter | LineJoin::MiterClip => LineJoinStyle::MiterJoin,
            LineJoin::Round => LineJoinStyle::RoundJoin,
            LineJoin::Bevel => LineJoinStyle::BevelJoin,
        });
        self.content.set_miter_limit(stroke.miterlimit().get());
        let dashes = stroke.dasharray().unwrap_or_default();
        self.content.set_dash_pattern(dashes.iter().copied(), stroke.dashoffset());
        self.opacity(stroke.opacity().get());
        Ok(())
    }

    /// Opacity of fills and strokes from here on, 0 to 1.
    fn opacity(&mut self, share: f32) {
        let bits = share.to_bits();
        let nth = self.shares.iter().position(|known| *known == bits).unwrap_or_else(|| {
            self.shares.push(bits);
            self.shares.len() - 1
        });
        self.content.set_parameters(Name(format!("O{nth}").as_bytes()));
    }

    fn picture(&mut self, image: &usvg::Image) -> Result<()> {
        let ImageKind::PNG(png) = image.kind() else { return Err(refusal("pictures that are no PNG")) };
        let (width, height) = (image.size().width(), image.size().height());
        // A picture of PDF fills the unit square, from its lower edge up.
        self.content.save_state().transform([width, 0.0, 0.0, -height, 0.0, height]);
        self.content.x_object(Name(format!("P{}", self.pictures.len()).as_bytes())).restore_state();
        self.pictures.push(png.to_vec());
        Ok(())
    }

    fn text(&mut self, text: &usvg::Text) -> Result<()> {
        for span in text.layouted().iter().filter(|span| span.visible) {
            let Some(fill) = &span.fill else { continue };
            self.fill(fill)?;
            self.content.begin_text();
            self.content.set_font(Name(b"F"), 1.0);
            for glyph in &span.positioned_glyphs {
                let number = self.typeface.glyph(glyph)?;
                // Outlines are in units of the typeface; text of size 1 has one unit an em.
                let matrix =
                    glyph.outline_transform().pre_scale(self.typeface.units(), self.typeface.units());
                self.content.set_text_matrix(numbers(matrix));
                self.content.show(Str(&number.to_be_bytes()));
            }
            self.content.end_text();
        }
        Ok(())
    }

    fn finish(self, [width, height]: [f32; 2]) -> Result<Vec<u8>> {
        let mut pdf = Pdf::new();
        let mut next = Ref::new(1);
        let [catalog, pages, page_id, content_id, info] = std::array::from_fn(|_| next.bump());
        pdf.catalog(catalog).pages(pages);
        pdf.pages(pages).kids([page_id]).count(1);
        pdf.document_info(info).producer(TextStr("Overlook"));
        let content = deflated(&self.content.finish())?;
        pdf.stream(content_id, &content).filter(Filter::FlateDecode);
        let pictures: Vec<Ref> = self.pictures.iter().map(|_| next.bump()).collect();
        for (png, id) in self.pictures.iter().zip(&pictures) {
            write_picture(&mut pdf, png, [*id, next.bump()])?;
        }
        let font =
            if self.typeface.is_used() { Some(self.typeface.write(&mut pdf, &mut next)?) } else { None };
        let mut page = pdf.page(page_id);
        page.media_box(Rect::new(0.0, 0.0, width, height)).parent(pages).contents(content_id);
        let mut resources = page.resources();
        if let Some(font) = font {
            resources.fonts().pair(Name(b"F"), font);
        }
        let mut named = resources.x_objects();
        for (nth, id) in pictures.iter().enumerate() {
            named.pair(Name(format!("P{nth}").as_bytes()), id);
        }
        named.finish();
        let mut states = resources.ext_g_states();
        for (nth, bits) in self.shares.iter().enumerate() {
            let share = f32::from_bits(*bits);
            let name = format!("O{nth}");
            states
                .insert(Name(name.as_bytes()))
                .start::<pdf_writer::writers::ExtGraphicsState>()
                .non_stroking_alpha(share)
                .stroking_alpha(share);
        }
        states.finish();
        resources.finish();
        page.finish();
        Ok(pdf.finish())
    }
}

/// A picture and its alpha, where it has some.
fn write_picture(pdf: &mut Pdf, png: &[u8], [id, mask]: [Ref; 2]) -> Result<()> {
    let picture = image::load_from_memory(png).map_err(|error| refusal(&error.to_string()))?;
    let [width, height] = [picture.width(), picture.height()].map(|side| side as i32);
    let alpha: Vec<u8> = picture.to_rgba8().pixels().map(|pixel| pixel.0[3]).collect();
    let is_opaque = alpha.iter().all(|share| *share == u8::MAX);
    let colors = deflated(picture.to_rgb8().as_raw())?;
    let mut object = pdf.image_xobject(id, &colors);
    object.width(width).height(height).bits_per_component(8).filter(Filter::FlateDecode);
    object.color_space().device_rgb();
    if !is_opaque {
        object.s_mask(mask);
    }
    object.finish();
    if !is_opaque {
        let alpha = deflated(&alpha)?;
        let mut object = pdf.image_xobject(mask, &alpha);
        object.width(width).height(height).bits_per_component(8).filter(Filter::FlateDecode);
        object.color_space().device_gray();
    }
    Ok(())
}

fn color(paint: &Paint) -> Result<[f32; 3]> {
    match paint {
        Paint::Color(color) => Ok([color.red, color.green, color.blue].map(|value| f32::from(value) / 255.0)),
        _ => Err(refusal("gradients and patterns")),
    }
}

fn numbers(transform: Transform) -> [f32; 6] {
    let Transform { sx, kx, ky, sy, tx, ty } = transform;
    [sx, ky, kx, sy, tx, ty]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pdf(body: &str) -> Result<Vec<u8>> {
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"96\" height=\"48\" font-family=\"Ubuntu\">{body}</svg>"
        );
        let mut options = usvg::Options::default();
        std::sync::Arc::make_mut(&mut options.fontdb)
            .load_font_data(super::super::type_metrics::FONT.to_vec());
        of_tree(&usvg::Tree::from_str(&svg, &options).unwrap())
    }

    fn holds(pdf: &[u8], text: &str) -> bool {
        pdf.windows(text.len()).any(|part| part == text.as_bytes())
    }

    #[test]
    fn a_page_has_the_size_of_the_sheet_and_brings_the_letters_that_it_shows_alone() {
        let pdf =
            pdf("<rect width=\"10\" height=\"5\" fill=\"#123456\"/><text y=\"20\">abc cab</text>").unwrap();
        assert!(pdf.starts_with(b"%PDF-1.7") && pdf.ends_with(b"%%EOF"));
        assert!(holds(&pdf, "/MediaBox [0 0 72 36]"));
        assert!(holds(&pdf, "/FontFile2") && holds(&pdf, "/ToUnicode"));
        assert!(pdf.len() < 20_000, "{} bytes for four letters", pdf.len());
    }

    #[test]
    fn a_page_without_text_has_no_typeface_and_what_no_chart_has_is_refused() {
        assert!(!holds(&pdf("<path d=\"M1 1L9 9\" stroke=\"#fff\"/>").unwrap(), "/Font"));
        let gradient = "<linearGradient id=\"g\"><stop stop-color=\"red\"/><stop offset=\"1\"/></linearGradient>\
                        <rect width=\"9\" height=\"9\" fill=\"url(#g)\"/>";
        let refused = pdf(gradient).unwrap_err().to_string();
        assert!(refused.contains("gradients"), "{refused}");
    }
}
