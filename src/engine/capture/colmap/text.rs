//! `cameras.txt` and `images.txt`.

use std::str::FromStr;

use super::lens_model::LensModel;
use super::model::{ColmapCamera, ColmapImage};
use crate::error::{Error, Result};

/// The cameras of `cameras.txt`: `CAMERA_ID MODEL WIDTH HEIGHT PARAMS…`; `place` is named in errors.
///
/// # Errors
/// `Invalid` and `Unsupported` with the line.
pub fn cameras_of_text(text: &str, place: &str) -> Result<Vec<ColmapCamera>> {
    lines(text, place).filter(ColmapLine::is_data).map(|line| camera(&line)).collect()
}

fn camera(line: &ColmapLine) -> Result<ColmapCamera> {
    let id = line.value(0)?;
    let name = line.field(1)?;
    let model = LensModel::of_name(name).ok_or_else(|| {
        let what = format!("model '{name}' of camera {id} is not known; undistort the images (colmap image_undistorter), and open that folder");
        Error::unsupported(line.place(), what)
    })?;
    let parameters: Vec<f64> =
        (4..line.fields.len()).map(|index| line.value(index)).collect::<Result<_>>()?;
    if parameters.len() != model.parameters.len() {
        let (found, wanted) = (parameters.len(), model.parameters.len());
        return Err(line.error(&format!("there are {found} parameters where {name} has {wanted}")));
    }
    Ok(ColmapCamera { id, model, width: line.value(2)?, height: line.value(3)?, parameters })
}

/// The images of `images.txt`, two lines each: `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME`, and its points, which may be none.
///
/// # Errors
/// `Invalid` with the line.
pub fn images_of_text(text: &str, place: &str) -> Result<Vec<ColmapImage>> {
    let mut images = Vec::new();
    let mut lines = lines(text, place).filter(|line| !line.is_comment);
    while let Some(line) = lines.next() {
        // Empty lines are those of images without points, and a last one.
        if line.fields.is_empty() {
            continue;
        }
        let name = line.fields.get(9..).unwrap_or_default().join(" ");
        if name.is_empty() {
            let what =
                format!("there are {} fields where an image has 10, its name the last", line.fields.len());
            return Err(line.error(&what));
        }
        images.push(ColmapImage {
            id: line.value(0)?,
            quaternion: [line.value(1)?, line.value(2)?, line.value(3)?, line.value(4)?],
            translation: [line.value(5)?, line.value(6)?, line.value(7)?],
            camera: line.value(8)?,
            name,
        });
        // Its points.
        lines.next();
    }
    Ok(images)
}

/// One line.
struct ColmapLine<'a> {
    place: &'a str,
    number: usize,
    fields: Vec<&'a str>,
    is_comment: bool,
}

fn lines<'a>(text: &'a str, place: &'a str) -> impl Iterator<Item = ColmapLine<'a>> {
    text.lines().enumerate().map(move |(index, text)| ColmapLine {
        place,
        number: index + 1,
        fields: text.split_whitespace().collect(),
        is_comment: text.trim_start().starts_with('#'),
    })
}

impl ColmapLine<'_> {
    fn is_data(&self) -> bool {
        !self.is_comment && !self.fields.is_empty()
    }

    fn place(&self) -> String {
        format!("{}, line {}", self.place, self.number)
    }

    fn error(&self, what: &str) -> Error {
        Error::invalid(self.place(), what)
    }

    fn field(&self, index: usize) -> Result<&str> {
        self.fields.get(index).copied().ok_or_else(|| {
            self.error(&format!("there are {} fields where {} are expected", self.fields.len(), index + 1))
        })
    }

    fn value<T: FromStr>(&self, index: usize) -> Result<T> {
        let field = self.field(index)?;
        field.parse().map_err(|_| self.error(&format!("'{field}' is no number of its kind")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_without_points_keeps_its_empty_line() {
        let text = "# comment\n1 1 0 0 0 1 2 3 1 a b.jpg\n\n2 1 0 0 0 1 2 3 1 c.jpg\n5.0 6.0 -1\n";
        let images = images_of_text(text, "").unwrap();
        let names: Vec<&str> = images.iter().map(|image| image.name.as_str()).collect();
        assert_eq!(names, ["a b.jpg", "c.jpg"]);
    }
}
