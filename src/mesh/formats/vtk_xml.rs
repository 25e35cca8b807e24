//! Arrays of VTK's XML files: text, base64 in place, or appended (raw or base64), of either byte order,
//! uncompressed or compressed with zlib.
//!
//! Binary data are preceded by a header of unsigned integers: uncompressed, one, the number of
//! bytes; compressed, the number of blocks, the size of a block, the size of the last block if
//! it is partial, and every block's compressed size. In base64 a compressed array's header is
//! encoded apart from the blocks.

use std::io::Read;

use flate2::read::ZlibDecoder;

use crate::mesh::formats::binary::Scalar;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::words::{Words, line_of, shown};
use crate::mesh::formats::xml::Tag;

/// The encoding common to all arrays: attributes of the tag `VTKFile`, and the appended data.
#[derive(Clone, Debug)]
pub(crate) struct VtkEncoding<'a> {
    big_endian: bool,
    header: Scalar,
    compressor: Option<&'a [u8]>,
    /// The appended data after their underscore.
    appended: Option<&'a [u8]>,
    appended_raw: bool,
}

impl<'a> VtkEncoding<'a> {
    /// Reads the attributes of the tag `VTKFile` and finds the appended data.
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
    encoding: &VtkEncoding<'_>,
) -> Result<Vec<f64>, ParseError> {
    let line = line_of(bytes, tag.end);
    let at_tag = |kind| ParseError::on_line(line, kind);
    let name = tag.attribute("type").unwrap_or_default();
    let kind = Scalar::named(&name.to_ascii_lowercase());
    let kind = kind.ok_or_else(|| at_tag(unknown("array of type", name)))?;
    let format = tag.attribute("format").unwrap_or(b"ascii");
    let content = tag.content(bytes);
    let data = match format {
        b"ascii" => return read_text(content, line),
        b"binary" => from_base64(content, encoding),
        b"appended" => appended(tag, encoding),
        _ => Err(unknown("array format", format)),
    };
    let data = data.map_err(at_tag)?;
    let decode = |number: &[u8]| kind.decode(number, encoding.big_endian);
    Ok(data.chunks_exact(kind.width()).map(decode).collect())
}

fn unknown(what: &str, name: &[u8]) -> ErrorKind {
    ErrorKind::unsupported(
        format!("the {what} {}", shown(name)),
        "export the file as ASCII",
    )
}

fn read_text(content: &[u8], line: usize) -> Result<Vec<f64>, ParseError> {
    let mut words = Words::new(content, None).on_line(line);
    let mut numbers = Vec::with_capacity(content.len() / 4);
    while let Some(word) = words.word() {
        numbers.push(words.parse_value(word)?);
    }
    Ok(numbers)
}

fn appended(tag: &Tag<'_>, encoding: &VtkEncoding<'_>) -> Result<Vec<u8>, ErrorKind> {
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

/// Decodes only as much base64 as the header announces: appended arrays follow one another.
fn from_base64(text: &[u8], encoding: &VtkEncoding<'_>) -> Result<Vec<u8>, ErrorKind> {
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
fn from_raw(data: &[u8], encoding: &VtkEncoding<'_>) -> Result<Vec<u8>, ErrorKind> {
    let width = encoding.header.width();
    let count = header_value(data, 0, encoding)?;
    match encoding.compressor {
        None => {
            let end = width.saturating_add(count);
            Ok(data.get(width..end).ok_or_else(too_short)?.to_vec())
        }
        Some(b"vtkZLibDataCompressor") => blocks(data, count, encoding, inflate),
        Some(b"vtkLZ4DataCompressor") => blocks(data, count, encoding, lz4),
        Some(name) => {
            let mend = "save it uncompressed, or compressed by zlib or LZ4";
            let what = format!("data of the compressor {}", shown(name));
            Err(ErrorKind::unsupported(what, mend))
        }
    }
}

/// Appends a block's unpacked bytes, at most as many as the number says.
type Unpack = fn(&[u8], usize, &mut Vec<u8>) -> Result<(), ErrorKind>;

/// All blocks unpacked. No block grows beyond the size of a whole one: damaged data must not fill
/// memory.
fn blocks(
    data: &[u8],
    count: usize,
    encoding: &VtkEncoding<'_>,
    unpack: Unpack,
) -> Result<Vec<u8>, ErrorKind> {
    let mut start = count
        .saturating_add(3)
        .saturating_mul(encoding.header.width());
    let whole = header_value(data, 1, encoding)?;
    let mut unpacked = Vec::new();
    for block in 0..count {
        let size = header_value(data, block + 3, encoding)?;
        let end = start.saturating_add(size);
        let packed = data.get(start..end).ok_or_else(too_short)?;
        unpack(packed, whole, &mut unpacked)?;
        start = end;
    }
    Ok(unpacked)
}

fn inflate(packed: &[u8], most: usize, unpacked: &mut Vec<u8>) -> Result<(), ErrorKind> {
    let read = ZlibDecoder::new(packed)
        .take(most as u64)
        .read_to_end(unpacked);
    read.map(drop)
        .map_err(|error| ErrorKind::Damaged(error.to_string()))
}

/// An LZ4 block: sequences of literals and of copies of what came before (lz4_Block_format.md).
fn lz4(packed: &[u8], most: usize, unpacked: &mut Vec<u8>) -> Result<(), ErrorKind> {
    let damaged = || ErrorKind::Damaged("an LZ4 block".to_owned());
    let first = unpacked.len();
    let mut rest = packed;
    while let Some((&token, after)) = rest.split_first() {
        rest = after;
        let literals = lz4_length(token >> 4, &mut rest).ok_or_else(damaged)?;
        let (copied, after) = rest.split_at_checked(literals).ok_or_else(damaged)?;
        unpacked.extend_from_slice(copied);
        rest = after;
        // The last sequence has no copy.
        let Some((&offset, after)) = rest.split_first_chunk::<2>() else {
            break;
        };
        rest = after;
        let offset = usize::from(u16::from_le_bytes(offset));
        let length = lz4_length(token & 15, &mut rest).ok_or_else(damaged)? + 4;
        let fits = unpacked.len() - first + length <= most;
        if offset == 0 || offset > unpacked.len() - first || !fits {
            return Err(damaged());
        }
        for _ in 0..length {
            unpacked.push(unpacked[unpacked.len() - offset]);
        }
    }
    Ok(())
}

/// A length of four bits, continued by bytes while they are 255.
fn lz4_length(bits: u8, rest: &mut &[u8]) -> Option<usize> {
    let mut length = usize::from(bits);
    let mut goes_on = bits == 15;
    while goes_on {
        let (&more, after) = rest.split_first()?;
        *rest = after;
        length = length.checked_add(usize::from(more))?;
        goes_on = more == 255;
    }
    Some(length)
}

fn header_value(data: &[u8], at: usize, encoding: &VtkEncoding<'_>) -> Result<usize, ErrorKind> {
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

/// The first `limit` bytes encoded in `text`, fewer if it is shorter. Padding may occur inside,
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
            return Err(ErrorKind::expected("base64", shown(&[letter])));
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
