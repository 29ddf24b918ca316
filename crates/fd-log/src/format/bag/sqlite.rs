//! The rows of a table of `SQLite`: database file format 3, <https://www.sqlite.org/fileformat2.html>, as far as a file
//! that is only read from front to back needs it. Numbers are big endian.

use std::{
    fs::File,
    io::{Read, Seek, SeekFrom},
};

use super::super::message::NoMessage;

/// Bytes of the header of a file (section 1.3), before the first page's own.
const HEADER: usize = 100;
/// Pages of a table whose rows are in it, and of one that leads to others (section 1.6).
const LEAF: u8 = 0x0d;
const INTERIOR: u8 = 0x05;
/// Most bytes of a row: what `SQLite` itself takes (`SQLITE_MAX_LENGTH`).
const MOST_ROW: u64 = 1_000_000_000;

fn unsound(found: impl Into<String>) -> NoMessage {
    NoMessage::Unsound(found.into())
}

fn cut() -> NoMessage {
    unsound("found a page or row that ends too early")
}

/// A value of a row (section 2.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Value<'a> {
    Null,
    Integer(i64),
    Real(f64),
    Bytes(&'a [u8]),
    Text(&'a [u8]),
}

impl Value<'_> {
    pub(super) fn text(self) -> Option<String> {
        match self {
            Self::Text(bytes) => Some(String::from_utf8_lossy(bytes).into_owned()),
            _ => None,
        }
    }

    pub(super) fn integer(self) -> Option<i64> {
        match self {
            Self::Integer(number) => Some(number),
            _ => None,
        }
    }
}

/// What is done with a row: with its number and its values.
type EachRow<'a> = dyn FnMut(i64, &[Value<'_>]) -> Result<(), NoMessage> + 'a;

/// A database that is read.
#[derive(Debug)]
pub(super) struct Database {
    from: File,
    /// Bytes of a page, and of those the ones that are used.
    page: usize,
    usable: usize,
    pages: u64,
}

impl Database {
    pub(super) fn open(mut from: File) -> Result<Self, NoMessage> {
        let mut header = [0; HEADER];
        from.seek(SeekFrom::Start(0))
            .and_then(|_| from.read_exact(&mut header))
            .map_err(|_| cut())?;
        let page = match u16::from_be_bytes([header[16], header[17]]) {
            1 => 65_536,
            size => usize::from(size),
        };
        let usable = page.saturating_sub(usize::from(header[20]));
        if !page.is_power_of_two() || page < 512 || usable < 480 {
            return Err(unsound(format!(
                "found pages of {page} bytes, of which {usable} are used"
            )));
        }
        // 0 where nothing was written yet.
        if !matches!(header[56..60], [0, 0, 0, 0 | 1]) {
            return Err(unsound("found texts that are not in UTF-8"));
        }
        let length = from.seek(SeekFrom::End(0)).map_err(|_| cut())?;
        Ok(Self { from, page, usable, pages: length / page as u64 })
    }

    /// Page of the root of each table, and the statement that has made it (section 2.6).
    pub(super) fn tables(&mut self) -> Result<Vec<(String, u32, String)>, NoMessage> {
        let mut tables = Vec::new();
        self.rows(1, &mut |_, values| {
            if let [kind, name, _, root, statement, ..] = values
                && kind.text().as_deref() == Some("table")
                && let (Some(name), Some(root), Some(statement)) =
                    (name.text(), root.integer(), statement.text())
                && let Ok(root) = u32::try_from(root)
            {
                tables.push((name, root, statement));
            }
            Ok(())
        })?;
        Ok(tables)
    }

    /// Goes through the rows of a table in the order of their numbers (section 1.5).
    pub(super) fn rows(&mut self, root: u32, each: &mut EachRow<'_>) -> Result<(), NoMessage> {
        // Every page belongs to one place, so a walk over more pages than there are goes in circles.
        let mut left = self.pages;
        // Pages that are still to be seen, the next one last.
        let mut open = vec![root];
        let mut row = Vec::new();
        while let Some(number) = open.pop() {
            left =
                left.checked_sub(1).ok_or_else(|| unsound("found pages that lead in a circle"))?;
            let page = self.page(number)?;
            let start = if number == 1 { HEADER } else { 0 };
            let head = page.get(start..).ok_or_else(cut)?;
            let (kind, count) = (byte(head, 0)?, usize::from(u16(head, 3)?));
            let pointers = match kind {
                LEAF => 8,
                INTERIOR => 12,
                kind => return Err(unsound(format!("found a page of kind {kind} in a table"))),
            };
            let cell = |i: usize| Ok::<usize, NoMessage>(usize::from(u16(head, pointers + 2 * i)?));
            if kind == INTERIOR {
                open.push(u32(head, 8)?);
                for i in (0..count).rev() {
                    open.push(u32(&page, cell(i)?)?);
                }
                continue;
            }
            for i in 0..count {
                let mut cell = page.get(cell(i)?..self.usable).ok_or_else(cut)?;
                let (length, id) = (varint(&mut cell)?, varint(&mut cell)?);
                self.payload(length, cell, &mut left, &mut row)?;
                each(id.cast_signed(), &values(&row)?)?;
            }
        }
        Ok(())
    }

    /// The bytes of a row, part of which may be on pages of their own (section 1.6, "cell payload overflow pages").
    fn payload(
        &mut self,
        length: u64,
        cell: &[u8],
        left: &mut u64,
        row: &mut Vec<u8>,
    ) -> Result<(), NoMessage> {
        if MOST_ROW < length {
            return Err(unsound(format!("found a row of {length} bytes, more than {MOST_ROW}")));
        }
        // A row is on pages of the file.
        if self.pages.saturating_mul(self.page as u64) < length {
            return Err(cut());
        }
        let length = usize::try_from(length).map_err(|_| cut())?;
        let most = self.usable - 35;
        let local = if length <= most {
            length
        } else {
            let least = (self.usable - 12) * 32 / 255 - 23;
            let fitting = least + (length - least) % (self.usable - 4);
            if fitting <= most { fitting } else { least }
        };
        row.clear();
        row.extend_from_slice(cell.get(..local).ok_or_else(cut)?);
        let mut next = if local < length { u32(cell, local)? } else { 0 };
        while row.len() < length {
            *left =
                left.checked_sub(1).ok_or_else(|| unsound("found pages that lead in a circle"))?;
            let page = self.page(next)?;
            next = u32(&page, 0)?;
            let wanted = (length - row.len()).min(self.usable - 4);
            row.extend_from_slice(page.get(4..4 + wanted).ok_or_else(cut)?);
        }
        Ok(())
    }

    /// A page, of those that count from 1.
    fn page(&mut self, number: u32) -> Result<Vec<u8>, NoMessage> {
        if number == 0 || self.pages < u64::from(number) {
            return Err(unsound(format!("found page {number} of {}", self.pages)));
        }
        let mut page = vec![0; self.page];
        let at = (u64::from(number) - 1) * self.page as u64;
        let read =
            self.from.seek(SeekFrom::Start(at)).and_then(|_| self.from.read_exact(&mut page));
        read.map_err(|_| cut())?;
        Ok(page)
    }
}

/// The values of a row (section 2.1).
fn values(row: &[u8]) -> Result<Vec<Value<'_>>, NoMessage> {
    let mut kinds = row;
    let head = usize::try_from(varint(&mut kinds)?).map_err(|_| cut())?;
    let used = row.len() - kinds.len();
    let mut kinds = row.get(used..head).ok_or_else(cut)?;
    let mut content = &row[head..];
    let mut found = Vec::new();
    while !kinds.is_empty() {
        let kind = varint(&mut kinds)?;
        let bytes = match kind {
            0 | 8 | 9 => 0,
            1..=4 => kind,
            5 => 6,
            6 | 7 => 8,
            10 | 11 => return Err(unsound(format!("found a value of kind {kind}"))),
            _ => (kind - 12) / 2,
        };
        let bytes = usize::try_from(bytes).map_err(|_| cut())?;
        let (value, rest) = content.split_at_checked(bytes).ok_or_else(cut)?;
        content = rest;
        found.push(match kind {
            0 => Value::Null,
            7 => Value::Real(f64::from_bits(integer(value).cast_unsigned())),
            8 | 9 => Value::Integer(i64::from(kind == 9)),
            1..=6 => Value::Integer(integer(value)),
            _ if kind % 2 == 0 => Value::Bytes(value),
            _ => Value::Text(value),
        });
    }
    Ok(found)
}

/// A number with a sign, of up to eight bytes.
fn integer(bytes: &[u8]) -> i64 {
    let first = bytes.first().map_or(0, |first| i64::from(first.cast_signed()));
    bytes.iter().skip(1).fold(first, |number, byte| number << 8 | i64::from(*byte))
}

/// A number of one to nine bytes, seven bits in each, eight in the ninth (section 1.6).
fn varint(from: &mut &[u8]) -> Result<u64, NoMessage> {
    let mut number = 0;
    for i in 0..9 {
        let (byte, rest) = from.split_first().ok_or_else(cut)?;
        *from = rest;
        if i == 8 {
            return Ok(number << 8 | u64::from(*byte));
        }
        number = number << 7 | u64::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            break;
        }
    }
    Ok(number)
}

fn byte(from: &[u8], at: usize) -> Result<u8, NoMessage> {
    from.get(at).copied().ok_or_else(cut)
}

fn u16(from: &[u8], at: usize) -> Result<u16, NoMessage> {
    Ok(u16::from_be_bytes([byte(from, at)?, byte(from, at + 1)?]))
}

fn u32(from: &[u8], at: usize) -> Result<u32, NoMessage> {
    Ok(u32::from(u16(from, at)?) << 16 | u32::from(u16(from, at + 2)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_seven_bits_a_byte() {
        // The largest of one byte, the least of two, and all bits of nine.
        for (bytes, number) in
            [(&[0x7f][..], 127), (&[0x81, 0x00][..], 128), (&[0xff; 9][..], u64::MAX)]
        {
            let mut from = bytes;
            assert_eq!(varint(&mut from).ok(), Some(number));
            assert!(from.is_empty());
        }
        assert!(varint(&mut &[0x80][..]).is_err());
    }

    #[test]
    fn a_row_has_its_kinds_first() {
        // NULL, 1, -2 of one byte, 258 of two, 0.5, "ab", three bytes.
        let row = [
            8, 0, 9, 1, 2, 7, 17, 18, 0xfe, 1, 2, 0x3f, 0xe0, 0, 0, 0, 0, 0, 0, b'a', b'b', 7, 8, 9,
        ];
        let expected = [
            Value::Null,
            Value::Integer(1),
            Value::Integer(-2),
            Value::Integer(258),
            Value::Real(0.5),
            Value::Text(b"ab"),
            Value::Bytes(&[7, 8, 9]),
        ];
        assert_eq!(values(&row).ok(), Some(expected.to_vec()));
        assert!(values(&row[..22]).is_err());
        assert_eq!(values(&[1]).ok(), Some(Vec::new()));
        assert!(values(&[0]).is_err());
    }
}
