//! Archives of Zemax (`.zar`): a lens file with its glass catalogues, each packed.
//!
//! The layout is that of the files themselves, as the package zmxtools (Tom Vettenburg) reads them: a
//! header of fixed length for each file, with its packed size and its name, and its bytes. Names that end
//! with `.LZW` are packed by LZW (Welch 1984) with codes of 9 bits and more, the highest bit first, and no
//! code for an end.

use std::path::{Path, PathBuf};

use petzval_lens::LensError;

/// Largest archive, and most that its lens and its catalogues unpack to (bytes). Catalogues have half a
/// megabyte each.
pub(super) const MAX_ARCHIVE: usize = 1 << 26;

/// Places in the header of a file (bytes).
struct Header {
    length: usize,
    /// Offset of the packed size, and its length.
    size: [usize; 2],
    name: usize,
    /// Whether the name is UTF-16.
    wide: bool,
}

const EARLIER: Header = Header { length: 0x14c, size: [0x0c, 4], name: 0x20, wide: false };
const LATEST: Header = Header { length: 0x288, size: [0x10, 8], name: 0x30, wide: true };

/// A lens file of an archive, and its glass catalogues.
pub(super) struct PackedLens {
    /// Path of the archive and name of the file in it.
    pub path: PathBuf,
    pub bytes: Vec<u8>,
    pub catalogues: Vec<(PathBuf, Vec<u8>)>,
}

/// Returns the header of an archive's file; `None` if the bytes are something else.
fn header(bytes: &[u8]) -> Option<&'static Header> {
    match bytes {
        [0xea, 0 | 3, 0, 0, ..] => Some(&EARLIER),
        [0xec, 3, 0, 0, ..] => Some(&LATEST),
        _ => None,
    }
}

/// Returns whether the first bytes of a file are those of an archive.
pub(super) fn is_archive(bytes: &[u8]) -> bool {
    header(bytes).is_some()
}

/// Unpacks the lens of an archive: the only one, or the one of this name.
///
/// # Errors
/// Returns an error if the archive is damaged, or holds no such lens, or several without a name.
pub(super) fn unpack(
    path: &Path,
    bytes: &[u8],
    entry: Option<&str>,
) -> Result<PackedLens, LensError> {
    let refuse = |found: String, expected: &str| LensError::Malformed {
        path: path.to_owned(),
        line: 1,
        column: None,
        found,
        expected: expected.to_owned(),
    };
    let damaged = |found: String| refuse(found, "the archive is damaged: save it again");
    let files = files(bytes).map_err(damaged)?;
    let of_kind = |kind: &'static str| {
        files.iter().filter(move |file| {
            let extension = Path::new(&file.name).extension();
            extension.is_some_and(|found| found.eq_ignore_ascii_case(kind))
        })
    };
    let is_wanted = |file: &&PackedFile| entry.is_none_or(|entry| file.name == entry);
    let wanted: Vec<&PackedFile> = of_kind("zmx").filter(is_wanted).collect();
    let [lens] = wanted[..] else {
        let names: Vec<&str> = of_kind("zmx").map(|file| &file.name[..]).collect();
        return Err(match (entry, &names[..]) {
            (_, []) => refuse(
                "an archive without a .zmx file".to_owned(),
                "expected a sequential lens of Zemax",
            ),
            (Some(entry), _) => refuse(
                format!("no \"{entry}\" in the archive"),
                &format!("it holds {}", names.join(", ")),
            ),
            (None, names) => refuse(
                format!("an archive of several lenses: {}", names.join(", ")),
                "choose one by FILE#NAME",
            ),
        });
    };
    let mut left = MAX_ARCHIVE;
    let mut unpacked = |file: &PackedFile| -> Result<(PathBuf, Vec<u8>), LensError> {
        let bytes =
            file.content(left).map_err(|found| damaged(format!("{}: {found}", file.name)))?;
        left -= bytes.len();
        Ok((path.join(&file.name), bytes))
    };
    let (path, bytes) = unpacked(lens)?;
    let catalogues = of_kind("agf").map(unpacked).collect::<Result<Vec<_>, _>>()?;
    Ok(PackedLens { path, bytes, catalogues })
}

/// A file in an archive.
struct PackedFile<'a> {
    /// Its name, without the ending of the packer.
    name: String,
    is_packed: bool,
    stored: &'a [u8],
}

impl PackedFile<'_> {
    /// Returns its content, of so many bytes at most.
    fn content(&self, most: usize) -> Result<Vec<u8>, String> {
        match self.is_packed {
            true => unpack_lzw(self.stored, most),
            false if self.stored.len() > most => Err(too_large()),
            false => Ok(self.stored.to_vec()),
        }
    }
}

fn too_large() -> String {
    format!("the archive unpacks to more than {} MiB", MAX_ARCHIVE >> 20)
}

/// Returns the files of an archive.
fn files(bytes: &[u8]) -> Result<Vec<PackedFile<'_>>, String> {
    let (mut files, mut rest) = (Vec::new(), bytes);
    while !rest.is_empty() {
        let at = bytes.len() - rest.len();
        let header = header(rest).ok_or_else(|| format!("no header of a file at byte {at}"))?;
        let head = rest.get(..header.length).ok_or("the last header is incomplete")?;
        let [start, length] = header.size;
        let mut size = [0; 8];
        size[..length].copy_from_slice(&head[start..start + length]);
        let size = u64::from_le_bytes(size);
        let name = name(&head[header.name..], header.wide);
        let stored = usize::try_from(size).ok().and_then(|size| rest[header.length..].get(..size));
        let stored = stored.ok_or_else(|| {
            let left = rest.len() - header.length;
            format!("\"{name}\" has {size} bytes, and {left} follow")
        })?;
        rest = &rest[header.length + stored.len()..];
        let ending = name.len().saturating_sub(4);
        let is_packed =
            name.get(ending..).is_some_and(|ending| ending.eq_ignore_ascii_case(".lzw"));
        let name = if is_packed { name[..ending].to_owned() } else { name };
        files.push(PackedFile { name, is_packed, stored });
    }
    Ok(files)
}

/// Returns a name that ends with a zero.
fn name(bytes: &[u8], wide: bool) -> String {
    match wide {
        true => {
            let units = bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]]));
            String::from_utf16_lossy(&units.take_while(|&unit| unit != 0).collect::<Vec<_>>())
        }
        false => {
            let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
            String::from_utf8_lossy(&bytes[..end]).into_owned()
        }
    }
}

/// Unpacks codes whose number of bits grows with the list of words, to so many bytes at most.
fn unpack_lzw(packed: &[u8], most: usize) -> Result<Vec<u8>, String> {
    /// Words of one byte.
    const BYTES: usize = 256;
    let mut unpacked: Vec<u8> = Vec::new();
    // Each further word, by its place in what is unpacked: a word with the byte that followed it.
    let mut words: Vec<(usize, usize)> = Vec::new();
    let mut last: Option<(usize, usize)> = None;
    let (mut bits, mut available, mut width) = (0u64, 0u32, 9u32);
    for &byte in packed {
        bits = bits << 8 | u64::from(byte);
        available += 8;
        if available < width {
            continue;
        }
        available -= width;
        let code = (bits >> available) as usize;
        bits &= (1 << available) - 1;
        let start = unpacked.len();
        let (from, length) = match (code.checked_sub(BYTES), last) {
            (None, _) => {
                unpacked.push(code as u8);
                (start, 0)
            }
            (Some(word), _) if word < words.len() => words[word],
            // The word that this code is about to add: the last one, and its first byte.
            (Some(word), Some((from, length))) if word == words.len() => (from, length + 1),
            _ => return Err(format!("code {code} at byte {start} names no word")),
        };
        if unpacked.len() + length > most {
            return Err(too_large());
        }
        for i in from..from + length {
            unpacked.push(unpacked[i]);
        }
        if let Some((from, length)) = last {
            words.push((from, length + 1));
        }
        last = Some((start, unpacked.len() - start));
        if BYTES + words.len() >= 1 << width {
            width += 1;
        }
    }
    Ok(unpacked)
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use petzval_base::io::ReadContext;

    /// Packs bytes, by a list of words of its own.
    fn lzw(bytes: &[u8]) -> Vec<u8> {
        let mut words: HashMap<Vec<u8>, usize> =
            (0..256).map(|byte| (vec![byte as u8], byte)).collect();
        let mut bits = Vec::new();
        let mut emit = |code: usize, count: usize| {
            // The reader knows one word less than the writer.
            let width = (count.max(256) as f64).log2().floor() as usize + 1;
            bits.extend((0..width.max(9)).rev().map(|bit| code >> bit & 1));
        };
        let mut word: Vec<u8> = Vec::new();
        for &byte in bytes {
            let longer = [&word[..], &[byte]].concat();
            if words.contains_key(&longer) {
                word = longer;
                continue;
            }
            emit(words[&word], words.len() - 1);
            words.insert(longer, words.len());
            word = vec![byte];
        }
        emit(words[&word], words.len() - 1);
        bits.chunks(8)
            .map(|bits| {
                bits.iter().enumerate().fold(0, |byte, (i, bit)| byte | (*bit as u8) << (7 - i))
            })
            .collect()
    }

    fn file(header: &Header, name: &str, content: &[u8]) -> Vec<u8> {
        let mut head = vec![0; header.length];
        head[..2].copy_from_slice(if header.wide { &[0xec, 3] } else { &[0xea, 0] });
        let [start, length] = header.size;
        let size = (content.len() as u64).to_le_bytes();
        head[start..start + length].copy_from_slice(&size[..length]);
        let name: Vec<u8> = match header.wide {
            true => name.encode_utf16().flat_map(u16::to_le_bytes).collect(),
            false => name.bytes().collect(),
        };
        head[header.name..header.name + name.len()].copy_from_slice(&name);
        head.extend(content);
        head
    }

    #[test]
    fn packed_bytes_of_all_widths_come_back() {
        let noise = (0..200_000u32).map(|i| (petzval_base::sampler::hash(i) >> 13) as u8 % 7);
        for bytes in [b"a".to_vec(), b"aaaaaaaaaaa".to_vec(), noise.collect()] {
            assert!(unpack_lzw(&lzw(&bytes), bytes.len()).unwrap() == bytes);
        }
        assert_eq!(unpack_lzw(&[], 0).unwrap(), b"");
        assert!(unpack_lzw(&[0xff; 4], 9).unwrap_err().contains("names no word"));
        assert!(unpack_lzw(&lzw(b"aaaaaaaaaaa"), 10).unwrap_err().contains("more than 64 MiB"));
    }

    /// 3 kB of equal bytes unpack to 2 MiB: a small archive of many such catalogues takes all memory.
    #[test]
    fn all_that_an_archive_unpacks_to_is_limited() {
        let packed = lzw(&vec![b' '; 1 << 21]);
        assert!(packed.len() < 4000, "{} bytes", packed.len());
        let archive = |catalogues| {
            let lens = file(&LATEST, "a.zmx", LENS.as_bytes());
            let one = file(&LATEST, "b.agf.lzw", &packed);
            [lens, one.repeat(catalogues)].concat()
        };
        assert!(unpack(Path::new("x.zar"), &archive(31), None).is_ok());
        let refusal = unpack(Path::new("x.zar"), &archive(32), None).err().expect("a refusal");
        assert!(refusal.to_string().contains("more than 64 MiB"), "{refusal}");
    }

    const LENS: &str = "MODE SEQ\nUNIT MM\nENPD 5\nSURF 0\n CURV 0\n DISZ INFINITY\nSURF 1\n STOP\n \
                        CURV 0.02\n DISZ 4\n GLAS OWNGLASS 0 0 0 0\n DIAM 6 1\nSURF 2\n CURV 0\n \
                        DISZ 90\n DIAM 6 1\nSURF 3\n CURV 0\n DISZ 0\n";
    const CATALOGUE: &str = "CC own\nNM OWNGLASS 2 000000.0 1.5168 64.17 0 0\nCD 1.03961212E+00 \
                             6.00069867E-03 2.31792344E-01 2.00179144E-02 1.01046945E+00 1.03560653E+02\n\
                             LD 0.31 2.3\n";

    #[test]
    fn a_lens_is_read_with_the_glasses_of_its_archive() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.zar");
        for header in [&EARLIER, &LATEST] {
            let files = [
                file(header, "Lens.ZMX.LZW", &lzw(LENS.as_bytes())),
                file(header, "other.dat", b"no lens"),
                file(header, "OWN.agf", CATALOGUE.as_bytes()),
            ];
            std::fs::write(&path, files.concat()).unwrap();
            let lens = super::super::read_with(&path, &ReadContext::default()).unwrap();
            let focal = petzval_lens::Paraxial::new(&lens).focal_length;
            assert!((focal - 50.0 / 0.5168).abs() < 0.01, "{focal}");
            assert!(lens.rows[0].glass.index(0.0, 486.1).is_ok_and(|blue| blue > 1.522));
        }
    }

    #[test]
    fn damaged_and_empty_archives_and_several_lenses_are_refused() {
        let lens = |name| file(&LATEST, name, LENS.as_bytes());
        let two = [lens("a.zmx"), lens("b.ZMX")].concat();
        let refusal = |bytes: &[u8], entry| match unpack(Path::new("x.zar"), bytes, entry) {
            Ok(lens) => lens.path.display().to_string(),
            Err(error) => error.to_string(),
        };
        assert!(refusal(&two, None).contains("several lenses: a.zmx, b.ZMX"));
        assert_eq!(refusal(&two, Some("b.ZMX")), "x.zar/b.ZMX");
        assert!(refusal(&two, Some("c")).contains("no \"c\" in the archive"));
        assert!(refusal(&lens("a.agf"), None).contains("without a .zmx file"));
        assert!(refusal(&two[..100], None).contains("incomplete"));
        assert!(refusal(&two[..700], None).contains("and 52 follow"));
        assert!(refusal(&[&lens("a.zmx")[..], b"rest"].concat(), None).contains("no header"));
        let mut huge = lens("a.zmx");
        huge[0x10..0x18].fill(0xff);
        assert!(refusal(&huge, None).contains("18446744073709551615 bytes"));
    }
}
