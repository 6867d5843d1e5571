//! Files of parts: the results of one machine, to be put together with those of others.
//!
//! ```text
//! DIR/NAME.part-2-of-6   { "overlook": "0.1.0", "of": "scene.ovl.scan", "part": "2/6", "inputs": { "settings": "…", … } }
//!                        what was made: bytes
//!                        number of these bytes, 20 digits; their CRC-32, 8 hexadecimal digits
//! ```
//!
//! The head names the inputs by hashes; a part is used only if the command that puts parts together has the same inputs.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use siphasher::sip128::SipHasher24;

use super::study;
use overlook_engine::error::{Error, Result};
use overlook_engine::part::Part;
use overlook_engine::whole_file;

/// Hashes of the inputs of a piece of work, by their names in messages.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Inputs(BTreeMap<String, String>);

impl Inputs {
    /// With one more input, which has this state.
    pub(crate) fn with(mut self, name: &str, state: &str) -> Self {
        self.0.insert(name.to_owned(), hash(state.as_bytes()));
        self
    }

    /// The first input that is another one in `other`.
    fn difference<'a>(&'a self, other: &'a Self) -> Option<&'a str> {
        let names = self.0.keys().chain(other.0.keys());
        names.map(String::as_str).find(|name| self.0.get(*name) != other.0.get(*name))
    }
}

/// 128 bits as hexadecimal digits: SipHash-2-4 (Aumasson and Bernstein, 2012) with a key of zeros, the same on every machine. It
/// tells states apart; it does not stand up to an attacker.
fn hash(bytes: &[u8]) -> String {
    format!("{:032x}", u128::from_be_bytes(SipHasher24::new().hash(bytes).as_bytes()))
}

/// The first line of a part.
#[derive(Debug, Serialize, Deserialize)]
struct Head {
    /// Version of the program.
    overlook: String,
    /// The kind of work.
    of: String,
    part: String,
    inputs: Inputs,
}

/// Bytes of the last line.
const TAIL_BYTES: u64 = 20 + 1 + 8 + 1;

fn tail(bytes: u64, crc32: u32) -> String {
    format!("{bytes:020} {crc32:08x}\n")
}

/// Counts what is written, and sums it up.
struct Summed<'a> {
    writer: &'a mut dyn Write,
    bytes: u64,
    crc32: crc32fast::Hasher,
}

impl Write for Summed<'_> {
    fn write(&mut self, data: &[u8]) -> std::io::Result<usize> {
        let written = self.writer.write(data)?;
        self.crc32.update(&data[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.writer.flush()
    }
}

/// A part that is complete and of the inputs that were asked for.
#[derive(Debug)]
pub(crate) struct OpenPart {
    /// Where it is.
    pub(crate) path: PathBuf,
    /// Its last line, which differs from that of any other part of the same inputs.
    pub(crate) tail: String,
    /// Positioned at the first byte of what was made.
    pub(crate) reader: BufReader<std::io::Take<File>>,
}

/// All parts of one piece of work.
#[derive(Debug)]
pub(crate) struct PartFiles {
    folder: PathBuf,
    /// Name of the work, as in `scene.ovl.scan`.
    name: String,
    inputs: Inputs,
    /// Options that make a part, without its number.
    made_by: String,
    is_single: bool,
}

impl PartFiles {
    /// The parts in `folder` of the work called `name` on these inputs, made by `options` and `--part`.
    pub(crate) fn new(folder: &Path, name: &str, inputs: Inputs, options: &str) -> Self {
        let (folder, name, made_by) = (folder.to_path_buf(), name.to_owned(), options.to_owned());
        Self { folder, name, inputs, made_by, is_single: false }
    }

    /// The one file of the work called `name`, made by `options`.
    pub(crate) fn single(folder: &Path, name: &str, inputs: Inputs, options: &str) -> Self {
        Self { is_single: true, ..Self::new(folder, name, inputs, options) }
    }

    /// Name of the file of a part.
    fn file_name(&self, part: Part) -> String {
        if self.is_single {
            return self.name.clone();
        }
        part.file_name(&self.name)
    }

    /// Where a part is, once it is complete.
    pub(crate) fn path(&self, part: Part) -> PathBuf {
        self.folder.join(self.file_name(part))
    }

    /// Writes the file of a part, by what `body` writes.
    ///
    /// # Errors
    /// Those of `body`, and `Io`; nothing is left behind then.
    pub(crate) fn write(&self, part: Part, body: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<()> {
        let path = self.path(part);
        let head = Head {
            overlook: study::version(),
            of: self.name.clone(),
            part: part.to_string(),
            inputs: self.inputs.clone(),
        };
        let head = serde_json::to_string(&head)
            .map_err(|error| Error::invalid(path.display(), error.to_string()))?;
        let io = |error| Error::io(&path, error);
        whole_file::write(&path, |writer| {
            writeln!(writer, "{head}").map_err(io)?;
            let mut summed = Summed { writer, bytes: 0, crc32: crc32fast::Hasher::new() };
            body(&mut summed)?;
            let tail = tail(summed.bytes, summed.crc32.clone().finalize());
            summed.writer.write_all(tail.as_bytes()).map_err(io)
        })
    }

    /// Whether a part is complete and of these inputs.
    pub(crate) fn is_complete(&self, part: Part) -> bool {
        self.open(part).is_ok()
    }

    /// A part, if it is complete and of these inputs.
    ///
    /// # Errors
    /// `Invalid` with the name of a part that is missing, damaged, or made from other inputs; `Io`.
    pub(crate) fn open(&self, part: Part) -> Result<OpenPart> {
        let (opened, start, bytes) = self.look(part)?;
        let io = |error| Error::io(&opened.path, error);
        let mut file = opened.reader.into_inner().into_inner();
        if sum_from(&mut file, start, bytes).map_err(io)? != opened.tail {
            return Err(self.refused(part, CUT_SHORT));
        }
        file.seek(SeekFrom::Start(start)).map_err(io)?;
        Ok(OpenPart { reader: BufReader::new(file.take(bytes)), ..opened })
    }

    /// The last line of a part of these inputs, which differs from that of any other part. The rest is not read.
    ///
    /// # Errors
    /// As [`PartFiles::open`].
    pub(crate) fn identity(&self, part: Part) -> Result<String> {
        Ok(self.look(part)?.0.tail)
    }

    /// A part of these inputs, the first byte of what was made, and their number.
    fn look(&self, part: Part) -> Result<(OpenPart, u64, u64)> {
        let path = self.path(part);
        let io = |error| Error::io(&path, error);
        let mut file = match File::open(&path) {
            Ok(file) => BufReader::new(file),
            Err(error) if error.kind() == ErrorKind::NotFound => return Err(self.refused(part, "is missing")),
            Err(error) => return Err(io(error)),
        };
        let mut line = Vec::new();
        (&mut file).take(MOST_HEAD_BYTES).read_until(b'\n', &mut line).map_err(io)?;
        let Ok(head) = serde_json::from_slice::<Head>(&line) else {
            return Err(self.refused(part, "is no part that this version wrote"));
        };
        if head.overlook != study::version() {
            return Err(self.refused(part, &format!("was made by Overlook {}", head.overlook)));
        }
        if (head.of.as_str(), &head.part) != (self.name.as_str(), &part.to_string()) {
            return Err(self.refused(part, "is another part under this name"));
        }
        if let Some(name) = self.inputs.difference(&head.inputs) {
            return Err(self.refused(part, &format!("was made from another state of the {name}")));
        }
        let (start, mut file) = (line.len() as u64, file.into_inner());
        let all = file.metadata().map_err(io)?.len();
        let bytes = all.checked_sub(start + TAIL_BYTES).ok_or_else(|| self.refused(part, CUT_SHORT))?;
        let tail = String::from_utf8(tail_of(&mut file, all).map_err(io)?).unwrap_or_default();
        if !tail.starts_with(&format!("{bytes:020} ")) {
            return Err(self.refused(part, CUT_SHORT));
        }
        let reader = BufReader::new(file.take(bytes));
        Ok((OpenPart { path, tail, reader }, start, bytes))
    }

    /// That a part cannot be used, and how to make it.
    pub(crate) fn refused(&self, part: Part, what: &str) -> Error {
        let made_by = &self.made_by;
        let how = if self.is_single { made_by.clone() } else { format!("{made_by} --part {part}") };
        Error::invalid(self.path(part).display(), format!("{what}; make it with {how}"))
    }
}

/// Longer first lines are none.
const MOST_HEAD_BYTES: u64 = 1 << 16;

const CUT_SHORT: &str = "is damaged or was not copied whole";

/// The last line that `bytes` bytes from `start` on should have.
fn sum_from(file: &mut File, start: u64, bytes: u64) -> std::io::Result<String> {
    file.seek(SeekFrom::Start(start))?;
    let mut reader = BufReader::with_capacity(1 << 18, file.take(bytes));
    let mut crc32 = crc32fast::Hasher::new();
    loop {
        let piece = reader.fill_buf()?;
        if piece.is_empty() {
            return Ok(tail(bytes, crc32.finalize()));
        }
        crc32.update(piece);
        let length = piece.len();
        reader.consume(length);
    }
}

/// The last line of a file of this many bytes.
fn tail_of(file: &mut File, bytes: u64) -> std::io::Result<Vec<u8>> {
    let mut tail = Vec::new();
    file.seek(SeekFrom::Start(bytes - TAIL_BYTES))?;
    file.read_to_end(&mut tail)?;
    Ok(tail)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(folder: &Path, capture: &str) -> PartFiles {
        let inputs = Inputs::default().with("capture", capture).with("settings", "s");
        PartFiles::new(folder, "scan", inputs, "--stage scan")
    }

    fn part(text: &str) -> Part {
        text.parse().unwrap()
    }

    fn write(files: &PartFiles, of: &str, bytes: &[u8]) {
        let io = |error| Error::io("part", error);
        files.write(part(of), |writer| writer.write_all(bytes).map_err(io)).unwrap();
    }

    fn read(files: &PartFiles, of: &str) -> Vec<u8> {
        let mut bytes = Vec::new();
        files.open(part(of)).unwrap().reader.read_to_end(&mut bytes).unwrap();
        bytes
    }

    fn refused(files: &PartFiles, of: &str) -> String {
        files.open(part(of)).unwrap_err().to_string()
    }

    #[test]
    fn a_part_gives_what_was_written_and_one_that_is_missing_damaged_or_of_other_inputs_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let now = files(folder.path(), "now");
        let said = refused(&now, "1/2");
        assert!(
            said.contains("scan.part-1-of-2: is missing; make it with --stage scan --part 1/2"),
            "{said}"
        );
        write(&now, "1/2", b"one\n");
        write(&now, "2/2", b"");
        assert!(read(&now, "1/2") == b"one\n" && read(&now, "2/2").is_empty());
        assert!(now.is_complete(part("1/2")) && !now.is_complete(part("1/3")));

        write(&files(folder.path(), "before"), "2/2", b"two");
        let said = refused(&now, "2/2");
        assert!(said.contains("scan.part-2-of-2: was made from another state of the capture"), "{said}");
        std::fs::copy(now.path(part("1/2")), now.path(part("1/3"))).unwrap();
        assert!(refused(&now, "1/3").contains("is another part under this name"));

        let path = now.path(part("1/2"));
        let text = std::fs::read_to_string(&path).unwrap();
        for damaged in [text[..text.len() - 2].to_owned(), text.replace("one", "uno")] {
            std::fs::write(&path, damaged).unwrap();
            assert!(refused(&now, "1/2").contains("scan.part-1-of-2: is damaged"));
        }
        std::fs::write(&path, "something else").unwrap();
        assert!(refused(&now, "1/2").contains("is no part"));
    }

    #[test]
    fn a_part_that_fails_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let failed = files(folder.path(), "now").write(Part::WHOLE, |writer| {
            writer.write_all(b"half").map_err(|error| Error::io("part", error))?;
            Err(Error::Cancelled)
        });
        assert!(failed.is_err() && std::fs::read_dir(folder.path()).unwrap().count() == 0);
    }

    #[test]
    fn states_have_the_hash_that_siphash_gives_on_every_machine() {
        assert_eq!(hash(b""), "5049d74780a3e07d4202ab47d4cef2f4");
        assert_eq!(hash(b"overlook"), "e98cf95b5d4d01dd20670805f2ff6593");
    }
}
