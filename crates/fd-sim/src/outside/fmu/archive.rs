//! The archive that an FMU is: as much of the format of ZIP files as is needed (PKWARE APPNOTE.TXT 6.3, sections
//! 4.3 to 4.4): files that are stored or deflated, without encryption and below 4 GB.

use std::{
    fs,
    path::{Component, Path, PathBuf},
};

use miniz_oxide::inflate::decompress_to_vec_with_limit;

/// Largest file that is unpacked, in bytes.
const LARGEST: usize = 1 << 30;
/// Longest comment at the end of an archive.
const LONGEST_COMMENT: usize = 0xffff;

/// What is wrong with an archive: where, what was expected, and what was found.
pub(super) type Wrong = (String, &'static str, String);

/// Unpacks an archive into a directory.
pub(super) fn unpack(archive: &[u8], into: &Path) -> Result<(), Wrong> {
    let end = end(archive).ok_or_else(|| {
        let found = format!("{} bytes without the end of one", archive.len());
        ("the file".to_owned(), "a ZIP archive", found)
    })?;
    let broken = |what: &str| (what.to_owned(), "a whole archive", "its end too early".to_owned());
    let entries = word16(archive, end + 10).ok_or_else(|| broken("the directory"))?;
    let mut at = word32(archive, end + 16).ok_or_else(|| broken("the directory"))? as usize;
    for _ in 0..entries {
        let entry = Entry::at(archive, at).ok_or_else(|| broken("the directory"))?;
        entry.unpack(archive, into)?;
        at = entry.next;
    }
    Ok(())
}

/// Where the record of the end is.
fn end(archive: &[u8]) -> Option<usize> {
    let last = archive.len().checked_sub(22)?;
    let first = last.saturating_sub(LONGEST_COMMENT);
    (first..=last).rev().find(|at| archive[*at..].starts_with(b"PK\x05\x06"))
}

fn word16(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?))
}

fn word32(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

/// A file, as the directory of the archive says.
struct Entry {
    name: String,
    flags: u16,
    method: u16,
    check: u32,
    packed: usize,
    size: usize,
    local: usize,
    /// Where the next one is.
    next: usize,
}

impl Entry {
    fn at(archive: &[u8], at: usize) -> Option<Self> {
        if !archive.get(at..)?.starts_with(b"PK\x01\x02") {
            return None;
        }
        let length = |offset: usize| Some(usize::from(word16(archive, at + offset)?));
        let (name, extra, comment) = (length(28)?, length(30)?, length(32)?);
        let bytes = archive.get(at + 46..at + 46 + name)?;
        Some(Self {
            name: String::from_utf8_lossy(bytes).into_owned(),
            flags: word16(archive, at + 8)?,
            method: word16(archive, at + 10)?,
            check: word32(archive, at + 16)?,
            packed: word32(archive, at + 20)? as usize,
            size: word32(archive, at + 24)? as usize,
            local: word32(archive, at + 42)? as usize,
            next: at + 46 + name + extra + comment,
        })
    }

    fn unpack(&self, archive: &[u8], into: &Path) -> Result<(), Wrong> {
        let wrong = |expected, found: String| (format!("entry `{}`", self.name), expected, found);
        let path = inside(&self.name).ok_or_else(|| {
            wrong("a path inside of the archive", "one that leaves it".to_owned())
        })?;
        let path = into.join(path);
        let io = |error: std::io::Error| wrong("to be written", error.to_string());
        if self.name.ends_with('/') {
            return fs::create_dir_all(path).map_err(io);
        }
        if self.flags & 1 != 0 {
            return Err(wrong("no encryption", "an encrypted file".to_owned()));
        }
        if LARGEST < self.size {
            return Err(wrong("at most 1 GB", format!("{} bytes", self.size)));
        }
        let data = self.data(archive).ok_or_else(|| wrong("its data", "none".to_owned()))?;
        let content = match self.method {
            0 => data.to_vec(),
            8 => decompress_to_vec_with_limit(data, LARGEST)
                .map_err(|error| wrong("deflated data", error.to_string()))?,
            other => return Err(wrong("method 0 or 8", format!("method {other}"))),
        };
        if content.len() != self.size || check(&content) != self.check {
            return Err(wrong("the size and checksum that are stated", "others".to_owned()));
        }
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(io)?;
        }
        fs::write(path, content).map_err(io)
    }

    fn data<'a>(&self, archive: &'a [u8]) -> Option<&'a [u8]> {
        if !archive.get(self.local..)?.starts_with(b"PK\x03\x04") {
            return None;
        }
        let length = |offset: usize| Some(usize::from(word16(archive, self.local + offset)?));
        let start = self.local + 30 + length(26)? + length(28)?;
        archive.get(start..start + self.packed)
    }
}

/// A relative path that does not leave where it begins.
fn inside(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(name.replace('\\', "/"));
    let is_plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
    path.components().all(is_plain).then_some(path)
}

/// CRC-32 of ISO 3309, as ZIP uses it.
fn check(bytes: &[u8]) -> u32 {
    let table: [u32; 256] = std::array::from_fn(|i| {
        (0..8).fold(u32::try_from(i).unwrap_or(0), |c, _| {
            if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 }
        })
    });
    !bytes.iter().fold(!0, |c, byte| table[((c ^ u32::from(*byte)) & 0xff) as usize] ^ (c >> 8))
}

#[cfg(test)]
mod tests {
    use miniz_oxide::deflate::compress_to_vec;

    use super::*;

    /// An archive of these files, deflated or stored.
    #[expect(clippy::cast_possible_truncation, reason = "small files")]
    fn zip(files: &[(&str, &[u8], bool)]) -> Vec<u8> {
        let (mut archive, mut directory) = (Vec::new(), Vec::new());
        for (name, content, deflates) in files {
            let data = if *deflates { compress_to_vec(content, 6) } else { content.to_vec() };
            let local = archive.len();
            let mut head = Vec::new();
            let method = if *deflates { 8_u16 } else { 0 };
            head.extend([20_u16, 0, method, 0, 0].iter().flat_map(|w| w.to_le_bytes()));
            let sizes = [check(content), data.len() as u32, content.len() as u32];
            head.extend(sizes.iter().flat_map(|w| w.to_le_bytes()));
            head.extend([name.len() as u16, 0].iter().flat_map(|w| w.to_le_bytes()));
            archive.extend(b"PK\x03\x04");
            archive.extend(&head);
            archive.extend(name.as_bytes());
            archive.extend(&data);
            directory.extend(b"PK\x01\x02\x14\x00");
            directory.extend(&head);
            directory.extend([0; 10]);
            directory.extend((local as u32).to_le_bytes());
            directory.extend(name.as_bytes());
        }
        let at = archive.len() as u32;
        archive.extend(&directory);
        archive.extend(b"PK\x05\x06\0\0\0\0");
        archive.extend([files.len() as u16; 2].iter().flat_map(|w| w.to_le_bytes()));
        archive.extend((directory.len() as u32).to_le_bytes());
        archive.extend(at.to_le_bytes());
        archive.extend([0; 2]);
        archive
    }

    #[test]
    fn files_are_unpacked_and_nothing_leaves_the_directory() {
        // The check value of the catalogue of CRCs.
        assert_eq!(check(b"123456789"), 0xcbf4_3926);
        let directory = tempfile::tempdir().unwrap();
        let long = b"deflate me ".repeat(100);
        let archive = zip(&[("a/b.txt", &long, true), ("c.txt", b"stored", false)]);
        unpack(&archive, directory.path()).unwrap();
        assert_eq!(fs::read(directory.path().join("a/b.txt")).unwrap(), long);
        assert_eq!(fs::read(directory.path().join("c.txt")).unwrap(), b"stored");

        let refused = |archive: &[u8]| unpack(archive, directory.path()).unwrap_err();
        assert_eq!(refused(&zip(&[("../d.txt", b"", false)])).2, "one that leaves it");
        assert_eq!(refused(&zip(&[("/d.txt", b"", false)])).2, "one that leaves it");
        assert_eq!(refused(b"no archive at all, and long enough").1, "a ZIP archive");
        let mut flipped = archive.clone();
        let place = flipped.windows(6).position(|w| w == b"stored").unwrap();
        flipped[place] ^= 1;
        assert_eq!(refused(&flipped).1, "the size and checksum that are stated");
        // However it is cut, it is refused.
        for n in 0..archive.len() {
            assert!(unpack(&archive[..n], directory.path()).is_err(), "{n}");
        }
    }
}
