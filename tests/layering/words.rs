//! Text that people read has the terms of the field: what the window says, what settings are explained by, and the guide.

use super::private_words::private_word;
use super::sources;

/// The texts in quotes of some code, each with the line that it begins in.
fn quoted(code: &str) -> Vec<(usize, String)> {
    let mut texts = Vec::new();
    let mut letters = code.chars().peekable();
    let mut line = 1;
    while let Some(letter) = letters.next() {
        match letter {
            '\n' => line += 1,
            '/' if letters.peek() == Some(&'/') => {
                letters.by_ref().find(|letter| *letter == '\n');
                line += 1;
            }
            // A letter in quotes may be a quotation mark.
            '\'' if letters.peek() == Some(&'"') => {
                letters.next();
            }
            '"' => {
                let (begins, mut text) = (line, String::new());
                while let Some(letter) = letters.next().filter(|letter| *letter != '"') {
                    line += usize::from(letter == '\n');
                    match letter {
                        // The next line goes on where its text begins.
                        '\\' if letters.next() == Some('\n') => {
                            line += 1;
                            while letters.next_if(|letter| letter.is_whitespace()).is_some() {}
                        }
                        '\\' => text.push(' '),
                        letter => text.push(letter),
                    }
                }
                texts.push((begins, text));
            }
            _ => {}
        }
    }
    texts
}

#[test]
fn what_people_read_in_the_window_has_the_terms_of_the_field() {
    let mut found = Vec::new();
    let mut texts = 0;
    for (name, code) in sources() {
        let shown = code.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
        let read = if name.starts_with("engine/settings/") {
            let help = shown.lines().enumerate().map(|(index, line)| (index + 1, line.trim().to_owned()));
            help.filter(|(_, line)| line.starts_with("///")).collect()
        } else if name.starts_with("desk/app/") && !name.starts_with("desk/app/tests/") {
            quoted(shown)
        } else {
            continue;
        };
        texts += read.len();
        for (line, text) in read {
            if let Some(word) = private_word(&text) {
                found.push(format!("{name}:{line}: {word:?} in {text:?}"));
            }
        }
    }
    let pages = [
        ("GUIDE.md", include_str!("../../GUIDE.md")),
        ("EXPORT.md", include_str!("../../EXPORT.md")),
        ("EDITING.md", include_str!("../../EDITING.md")),
        ("SCIENCE.md", include_str!("../../SCIENCE.md")),
    ];
    for (page, text) in pages {
        for (index, line) in text.lines().enumerate() {
            found.extend(private_word(line).map(|word| format!("{page}:{}: {word:?}", index + 1)));
        }
    }
    assert!(texts > 1500, "{texts} texts were read");
    assert!(found.is_empty(), "say it as the field does:\n{}", found.join("\n"));
}

#[test]
fn texts_are_found_over_lines_and_beside_comments_and_letters() {
    let code = "a(\"one \\\n   two\"); // \"no text\"\nb('\"', \"a \\\"three\\\"\");";
    assert_eq!(quoted(code), [(1, "one two".to_owned()), (3, "a  three ".to_owned())]);
    assert_eq!(private_word("it was painted twice"), Some("painted"));
    assert_eq!(private_word("it was repainted"), None);
    assert_eq!((private_word("Along"), private_word("Along the way")), (Some("Along"), None));
}
