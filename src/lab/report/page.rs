//! The page itself.

use std::fmt::Write;

use super::results::CaptureResults;
use super::sections;
use super::together::overall;
use overlook_engine::page::escaped;

const STYLE: &str = "\
body { font: 15px/1.5 Ubuntu, system-ui, sans-serif; color: #22262b; max-width: 1180px; margin: 2em auto; padding: 0 1.5em; }
h1 { font-size: 1.8em; } h2 { margin-top: 2em; border-top: 2px solid #e4e7eb; padding-top: .8em; }
table { border-collapse: collapse; width: 100%; font-size: .86em; margin: 1em 0; font-variant-numeric: tabular-nums; }
th, td { padding: .25em .6em; text-align: right; border-bottom: 1px solid #e4e7eb; }
th:first-child, td:first-child { text-align: left; } th { color: #6b7480; font-weight: 600; }
.default { font-weight: 700; } .other { color: #a0467f; } .note { color: #6b7480; font-size: .9em; }
.chart svg { width: 100%; height: auto; } figure { margin: 1em 0; break-inside: avoid; }
img { max-width: 100%; image-rendering: auto; } figcaption { color: #6b7480; font-size: .9em; }
pre { background: #f5f6f8; padding: .8em; overflow-x: auto; white-space: pre-wrap; font-size: .82em; }
@page { size: A4; margin: 12mm; }
@media print { body { margin: 0; padding: 0; max-width: none; font-size: 10pt; } p { orphans: 3; widows: 3; }
  tr, .chart, figure { break-inside: avoid; } thead { display: table-header-group; } table { font-size: 7.5pt; }
  td { white-space: nowrap; padding: .2em .5em; } td:first-child { white-space: normal; }
  tbody tr:nth-child(-n+3):not(:first-child), tbody tr:nth-last-child(-n+3) { break-before: avoid; }
  h2, h3, h3 + .note { break-after: avoid; } table + .note { break-before: avoid; }
  section { break-before: page; } section > h2 { margin-top: 0; border-top: none; padding-top: 0; }
  .chart svg { max-height: 230mm; } figure { margin: .6em 0; } img { max-height: 225mm; } pre { overflow: visible; } }
";

/// A page on captures that needs no other file: style, charts and pictures are embedded, and there is no script.
pub fn page(captures: &[CaptureResults]) -> String {
    let names: Vec<&str> = captures.iter().map(|capture| capture.name.as_str()).collect();
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
         <title>Overlook: {title}</title>\n<style>{STYLE}</style></head><body>\n<h1>Accuracy, size, speed and stability</h1>\n<p>",
        title = escaped(&names.join(", "))
    );
    let rows = overall(captures);
    if !rows.is_empty() {
        html += "<a href=\"#together\">All together</a> · ";
    }
    let links: Vec<String> = names
        .iter()
        .enumerate()
        .map(|(index, name)| format!("<a href=\"#capture{index}\">{}</a>", escaped(name)))
        .collect();
    html += &(links.join(" · ") + " · <a href=\"#repeat\">To repeat it</a></p>\n");
    html += "<p>Settings and methods are measured at the same viewpoints and frames. Bars and ± are one standard error of the mean \
             difference to the most accurate one, viewpoint by viewpoint: frames of one viewpoint count as one.</p>\n";
    if !rows.is_empty() {
        html +=
            &sections::together(&rows, captures.iter().filter(|capture| !capture.points.is_empty()).count());
    }
    for (index, capture) in captures.iter().enumerate() {
        html += &sections::capture(capture, &format!("capture{index}"));
    }
    html += "<section><h2 id=\"repeat\">To repeat it</h2>\n";
    let mut versions: Vec<&str> =
        captures.iter().flat_map(|capture| &capture.versions).map(String::as_str).collect();
    versions.sort_unstable();
    versions.dedup();
    let _ = writeln!(html, "<p>Measured by Overlook {}.</p>\n<pre>", escaped(&versions.join(" and ")));
    let mut commands: Vec<&String> = captures.iter().flat_map(|capture| &capture.commands).collect();
    commands.dedup();
    for command in commands {
        let _ = writeln!(html, "{}", escaped(command));
    }
    html += "</pre>\n";
    html += &sections::settings(captures);
    html + "</section></body></html>\n"
}

#[cfg(test)]
mod tests {
    use super::super::results::CaptionedPicture;
    use super::super::tests::capture;
    use super::*;

    #[test]
    fn a_page_stands_by_itself_names_what_it_shows_and_says_who_is_ahead() {
        let mut first = capture("a <b>", 20.0, 21.0);
        first.commands = vec!["overlook sweep \"a\" --out x".to_owned()];
        first.versions = vec!["1.2.3".to_owned()];
        first.worst = vec![CaptionedPicture { caption: "view 1 & 2".to_owned(), png: vec![1, 2, 3] }];
        let html = page(&[first, capture("b", 40.0, 36.0)]);
        for wanted in [
            "a &lt;b&gt;",
            "overlook sweep &quot;a&quot; --out x",
            "Overlook 1.2.3",
            "data:image/png;base64,AQID",
            "view 1 &amp; 2",
            "All 2 captures together",
            "TSDF volume",
            "[pruning]",
            "tr, .chart, figure { break-inside: avoid; }",
        ] {
            assert!(html.contains(wanted), "{wanted}");
        }
        for forbidden in ["<script", "http://", "https://", "src=\"/", "<link"] {
            let found = html.replace("http://www.w3.org/2000/svg", "");
            assert!(!found.contains(forbidden), "{forbidden}");
        }
        assert_eq!(html.matches("<svg").count(), 3, "one chart for each capture and one of all together");
    }
}
