//! The numbers of a `DataArray` in VTK's XML files, in every encoding.
//!
//! Binary data are preceded by a header of unsigned integers: uncompressed, one, the number of
//! bytes; compressed, the number of blocks, the size of a block, the size of the last block if
//! it is partial, and every block's compressed size. In base64 a compressed array's header is
//! encoded apart from the blocks.

use std::io::Read;

use flate2::read::ZlibDecoder;

use crate::mesh::formats::binary::Scalar;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::words::{Words, shown};
use crate::mesh::formats::xml::{Tag, line_of, text_at};

/// What the tag `VTKFile` and the appended data tell about all arrays.
#[derive(Clone, Debug)]
pub(crate) struct Encoding<'a> {
    big_endian: bool,
    header: Scalar,
    compressor: Option<&'a [u8]>,
    /// The appended data after their underscore.
    appended: Option<&'a [u8]>,
    appended_raw: bool,
}

impl<'a> Encoding<'a> {
    /// Reads the attributes of the tag `VTKFile` and looks for appended data.
    pub(crate) fn of(file: &Tag<'a>, bytes: &'a [u8]) -> Self {
        let appended = find_appended(bytes, file.end);
        let is_wide = file.attribute("header_type") == Some(b"UInt64");
        Self {
            big_endian: file.attribute("byte_order") == Some(b"BigEndian"),
            header: if is_wide {
                Scalar::UInt64
            } else {
                Scalar::UInt32
            },
            compressor: file.attribute("compressor").filter(|name| !name.is_empty()),
            appended: appended.as_ref().map(|&(_, data)| data),
            appended_raw: appended.is_some_and(|(is_raw, _)| is_raw),
        }
    }
}

/// All numbers of the array whose opening tag is `tag`. Integers beyond 2⁵³ are rounded.
pub(crate) fn decode(
    bytes: &[u8],
    tag: &Tag<'_>,
    encoding: &Encoding<'_>,
) -> Result<Vec<f64>, ParseError> {
    let line = line_of(bytes, tag.end);
    let at_tag = |kind| ParseError::on_line(line, kind);
    let name = tag.attribute("type").unwrap_or_default();
    let kind = scalar(name).ok_or_else(|| at_tag(unknown("array of type", name)))?;
    let format = tag.attribute("format").unwrap_or(b"ascii");
    let content = if tag.is_empty() {
        &b""[..]
    } else {
        text_at(bytes, tag.end)
    };
    let data = match format {
        b"ascii" => return read_text(content, line),
        b"binary" => from_base64(content, encoding),
        b"appended" => appended(tag, encoding),
        _ => Err(unknown("array format", format)),
    };
    let data = data.map_err(at_tag)?;
    let numbers = data.chunks_exact(kind.width());
    Ok(numbers
        .map(|number| kind.decode(number, encoding.big_endian))
        .collect())
}

fn scalar(name: &[u8]) -> Option<Scalar> {
    Some(match name {
        b"Int8" => Scalar::Int8,
        b"UInt8" => Scalar::UInt8,
        b"Int16" => Scalar::Int16,
        b"UInt16" => Scalar::UInt16,
        b"Int32" => Scalar::Int32,
        b"UInt32" => Scalar::UInt32,
        b"Int64" => Scalar::Int64,
        b"UInt64" => Scalar::UInt64,
        b"Float32" => Scalar::Float32,
        b"Float64" => Scalar::Float64,
        _ => return None,
    })
}

fn unknown(what: &str, name: &[u8]) -> ErrorKind {
    ErrorKind::Unsupported {
        what: format!("the {what} {}", shown(name)),
        mend: "export the file as ASCII",
    }
}

fn read_text(content: &[u8], line: usize) -> Result<Vec<f64>, ParseError> {
    let mut words = Words::new(content, None).on_line(line);
    let mut numbers = Vec::with_capacity(content.len() / 4);
    while let Some(word) = words.word() {
        numbers.push(words.parse_number(word, "a number")?);
    }
    Ok(numbers)
}

fn appended(tag: &Tag<'_>, encoding: &Encoding<'_>) -> Result<Vec<u8>, ErrorKind> {
    let expected = "appended data";
    let offset = tag
        .attribute("offset")
        .and_then(|offset| std::str::from_utf8(offset).ok()?.parse::<usize>().ok());
    let data = encoding.appended.ok_or(ErrorKind::Truncated { expected })?;
    let data = offset
        .and_then(|offset| data.get(offset..))
        .ok_or(ErrorKind::Truncated { expected })?;
    if encoding.appended_raw {
        return from_raw(data, encoding);
    }
    let end = data
        .iter()
        .position(|&byte| byte == b'<')
        .unwrap_or(data.len());
    from_base64(&data[..end], encoding)
}

/// Decodes no more base64 than the header asks for: appended arrays follow one another.
fn from_base64(text: &[u8], encoding: &Encoding<'_>) -> Result<Vec<u8>, ErrorKind> {
    let text = text.trim_ascii();
    let width = encoding.header.width();
    let first = base64(text, width)?;
    let count = header_value(&first, 0, encoding)?;
    if encoding.compressor.is_none() {
        return from_raw(&base64(text, width.saturating_add(count))?, encoding);
    }
    let header_size = count.saturating_add(3).saturating_mul(width);
    let header = base64(text, header_size)?;
    if header.len() < header_size {
        return Err(too_short());
    }
    let compressed: usize = (0..count).try_fold(0_usize, |sum, block| {
        Ok::<_, ErrorKind>(sum.saturating_add(header_value(&header, block + 3, encoding)?))
    })?;
    let blocks = text.get(header_size.div_ceil(3) * 4..).unwrap_or_default();
    let mut data = header;
    data.extend(base64(blocks, compressed)?);
    from_raw(&data, encoding)
}

/// The payload of header and data.
fn from_raw(data: &[u8], encoding: &Encoding<'_>) -> Result<Vec<u8>, ErrorKind> {
    let width = encoding.header.width();
    let count = header_value(data, 0, encoding)?;
    match encoding.compressor {
        None => {
            let end = width.saturating_add(count);
            Ok(data.get(width..end).ok_or_else(too_short)?.to_vec())
        }
        Some(b"vtkZLibDataCompressor") => inflate(data, count, encoding),
        Some(name) => Err(unknown("compressor", name)),
    }
}

fn inflate(data: &[u8], blocks: usize, encoding: &Encoding<'_>) -> Result<Vec<u8>, ErrorKind> {
    let mut start = blocks
        .saturating_add(3)
        .saturating_mul(encoding.header.width());
    // A damaged block must not blow up beyond the size of a whole one.
    let whole = header_value(data, 1, encoding)? as u64;
    let mut inflated = Vec::new();
    for block in 0..blocks {
        let size = header_value(data, block + 3, encoding)?;
        let end = start.saturating_add(size);
        let compressed = data.get(start..end).ok_or_else(too_short)?;
        let broken = |_| unknown("damaged zlib block", b"");
        ZlibDecoder::new(compressed)
            .take(whole)
            .read_to_end(&mut inflated)
            .map_err(broken)?;
        start = end;
    }
    Ok(inflated)
}

fn header_value(data: &[u8], at: usize, encoding: &Encoding<'_>) -> Result<usize, ErrorKind> {
    let width = encoding.header.width();
    let start = at.saturating_mul(width);
    let bytes = data
        .get(start..start.saturating_add(width))
        .ok_or_else(too_short)?;
    Ok(encoding.header.decode(bytes, encoding.big_endian) as usize)
}

fn too_short() -> ErrorKind {
    let expected = "the rest of an array";
    ErrorKind::Truncated { expected }
}

/// The first `limit` bytes encoded in `text`, fewer if it is shorter. Padding may stand inside,
/// where encoded parts follow one another.
fn base64(text: &[u8], limit: usize) -> Result<Vec<u8>, ErrorKind> {
    let mut bytes = Vec::with_capacity(limit.min(text.len()));
    for group in text.chunks(4) {
        if bytes.len() >= limit {
            break;
        }
        let mut bits = 0_u32;
        let mut digits = 0;
        for &letter in group.iter().take_while(|&&letter| letter != b'=') {
            bits = bits << 6 | digit(letter)?;
            digits += 1;
        }
        bits <<= 6 * (4 - digits);
        let count = (digits as usize * 6) / 8;
        bytes.extend_from_slice(&bits.to_be_bytes()[1..=count]);
    }
    bytes.truncate(limit);
    Ok(bytes)
}

fn digit(letter: u8) -> Result<u32, ErrorKind> {
    let value = match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => {
            let (expected, found) = ("base64", shown(&[letter]));
            return Err(ErrorKind::Expected { expected, found });
        }
    };
    Ok(u32::from(value))
}

/// Whether the appended data are raw, and the data after their underscore.
fn find_appended(bytes: &[u8], from: usize) -> Option<(bool, &[u8])> {
    const OPENING: &[u8] = b"<AppendedData";
    let rest = &bytes[from..];
    let start = rest
        .windows(OPENING.len())
        .position(|window| window == OPENING)?;
    let rest = &rest[start..];
    let end = rest.iter().position(|&byte| byte == b'>')?;
    let is_raw = rest[..end].windows(5).any(|window| window == b"\"raw\"");
    let underscore = rest[end..].iter().position(|&byte| byte == b'_')?;
    Some((is_raw, &rest[end + underscore + 1..]))
}
