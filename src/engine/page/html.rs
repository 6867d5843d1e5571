//! The text of a page: the files of `assets/page/`, the header and the chunks in one.
//!
//! The modules of the page are joined into one script in the order of their imports, without their `import` and `export` words, in a
//! scope of their own. Chunks follow the script, so that the first frame is shown while later ones are still on their way.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use overlook_page::{MODULES, STYLE, TEMPLATE};

use super::chunks::Packed;
use super::header::Header;
use super::options::PageOptions;
use crate::error::{Error, Result};

/// The whole page; `name` is that of the capture.
pub(super) fn page(header: &Header, options: &PageOptions, packed: &Packed, name: &str) -> Result<String> {
    let header = serde_json::to_string(header).map_err(|error| Error::invalid(name, error.to_string()))?;
    let mut html = String::new();
    // Each piece of the template ends where something is put in.
    for (nth, piece) in TEMPLATE.split("<!-- ").enumerate() {
        let Some((slot, rest)) = piece.split_once(" -->").filter(|_| nth > 0) else {
            html += piece;
            continue;
        };
        match slot {
            "title" => html += &escaped(options.title.as_deref().unwrap_or(name)),
            "style" => html += STYLE,
            // Inside a script nothing but its end is markup.
            "header" => html += &header.replace('<', "\\u003c"),
            "script" => html += &script(),
            "chunks" => push_chunks(&mut html, packed),
            _ => return Err(Error::invalid(name, format!("the template asks for {slot}"))),
        }
        html += rest;
    }
    Ok(html)
}

fn push_chunks(html: &mut String, packed: &Packed) {
    for chunk in &packed.chunks {
        html.push_str("<script type=\"text/plain\" class=\"chunk\">");
        STANDARD.encode_string(&chunk.bytes, html);
        html.push_str("</script>\n");
    }
}

/// All modules as one script, without comments and indentation: pages are sent, and `assets/page/` is what people read.
fn script() -> String {
    let mut script = String::from("\"use strict\";\n(() => {\n");
    for (_, module) in MODULES {
        let (mut is_import, mut is_comment) = (false, false);
        for line in module.lines() {
            is_import |= line.starts_with("import ");
            if is_import {
                is_import = !line.ends_with("\";");
                continue;
            }
            let line = line.strip_prefix("export ").unwrap_or(line).trim_start();
            is_comment |= line.starts_with("/**");
            if is_comment {
                is_comment = !line.ends_with("*/");
            } else if !line.is_empty() && !line.starts_with("//") {
                script.extend([line, "\n"]);
            }
        }
    }
    script + "})();\n"
}

/// Text as HTML shows it, in elements and in quoted attributes.
#[must_use]
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_has_no_module_words_and_cannot_end_early() {
        let script = script();
        let starts = |word: &str| script.lines().any(|line| line.starts_with(word));
        assert!(!starts("import ") && !starts("export "));
        assert!(!script.contains("</script") && !script.contains("<!--"));
    }

    #[test]
    fn no_two_modules_declare_the_same_name() {
        let declared = |module: &str| {
            let words = ["const ", "let ", "class ", "function ", "async function "];
            let declared: Vec<String> = module
                .lines()
                .map(|line| line.strip_prefix("export ").unwrap_or(line))
                .filter_map(|line| words.iter().find_map(|word| line.strip_prefix(word)))
                // Constants of shaders have a type before their name, and what is taken apart has none.
                .filter(|rest| {
                    !["float ", "int ", "uint ", "vec", "ivec", "{", "["]
                        .iter()
                        .any(|start| rest.starts_with(start))
                })
                .map(|rest| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect())
                .collect();
            declared
        };
        let mut names: Vec<String> = MODULES.iter().flat_map(|(_, module)| declared(module)).collect();
        names.sort();
        let twice: Vec<_> = names.windows(2).filter(|pair| pair[0] == pair[1]).collect();
        assert!(twice.is_empty() && names.len() > 20, "{twice:?}");
    }
}
