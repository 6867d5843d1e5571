//! HTML, put together piece by piece.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::results::CaptionedPicture;
use overlook_engine::page::escaped;

/// A table: a heading for each column, and rows of cells that are HTML already. The first column holds text, the others numbers.
pub(super) fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut html = String::from("<table><thead><tr>");
    for name in head {
        let _ = write!(html, "<th>{}</th>", escaped(name));
    }
    html.push_str("</tr></thead><tbody>\n");
    for row in rows {
        html.push_str("<tr>");
        for cell in row {
            let _ = write!(html, "<td>{cell}</td>");
        }
        html.push_str("</tr>\n");
    }
    html + "</tbody></table>\n"
}

/// A picture in the page itself, with its caption.
pub(super) fn figure(figure: &CaptionedPicture) -> String {
    let caption = escaped(&figure.caption);
    format!(
        "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{}\"><figcaption>{caption}</figcaption></figure>\n",
        STANDARD.encode(&figure.png)
    )
}

/// A chart in the page itself, as wide as the page.
pub(super) fn embedded(svg: &str) -> String {
    // The size comes from the view box, so that the page decides.
    let size = svg.find(" width=").zip(svg.find(" viewBox="));
    let scaled = size.map_or_else(|| svg.to_owned(), |(from, to)| format!("{}{}", &svg[..from], &svg[to..]));
    format!("<div class=\"chart\">{scaled}</div>\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_encoded_as_the_standards_own_test_vectors() {
        let vectors = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (plain, encoded) in vectors {
            let shown = figure(&CaptionedPicture { caption: String::new(), png: plain.as_bytes().to_vec() });
            assert!(shown.contains(&format!("base64,{encoded}\"")), "{shown}");
        }
    }

    #[test]
    fn charts_take_the_width_of_the_page() {
        let scaled = embedded(
            "<svg xmlns=\"x\" width=\"1800\" height=\"1040\" viewBox=\"0 0 1800 1040\" font-family=\"F\">",
        );
        assert_eq!(
            scaled.trim(),
            "<div class=\"chart\"><svg xmlns=\"x\" viewBox=\"0 0 1800 1040\" font-family=\"F\"></div>"
        );
    }
}
