//! The header of a PLY file: encoding, elements and their properties.

use crate::mesh::formats::binary::Scalar;
use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::words::{Words, shown};

/// How the numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Text,
    Little,
    Big,
}

/// All that stands before the data.
#[derive(Clone, Debug)]
pub(crate) struct Header {
    pub(crate) encoding: Encoding,
    pub(crate) elements: Vec<Element>,
}

/// A kind of element, such as `vertex`.
#[derive(Clone, Debug)]
pub(crate) struct Element {
    pub(crate) name: String,
    pub(crate) count: usize,
    pub(crate) properties: Vec<Property>,
}

/// A property of an element: a number, or a list preceded by its length of type `list`.
#[derive(Clone, Debug)]
pub(crate) struct Property {
    pub(crate) name: String,
    pub(crate) list: Option<Scalar>,
    pub(crate) kind: Scalar,
}

/// Reads up to and including the line `end_header`.
pub(crate) fn read_header(words: &mut Words<'_>) -> Result<Header, ParseError> {
    let magic = words.some_word("the header ply")?;
    if magic != b"ply" {
        return Err(words.unexpected("the header ply", magic));
    }
    let mut encoding = None;
    let mut elements = Vec::new();
    loop {
        words.next_line();
        let word = words.some_word("end_header")?;
        match word {
            b"end_header" => break,
            b"comment" | b"obj_info" => {}
            b"format" => encoding = Some(read_encoding(words)?),
            b"element" => elements.push(read_element(words)?),
            b"property" => read_property(words, &mut elements)?,
            _ => return Err(words.unexpected("a header line", word)),
        }
    }
    let missing = || words.unexpected("a line `format`", b"end_header");
    let encoding = encoding.ok_or_else(missing)?;
    words.next_line();
    Ok(Header { encoding, elements })
}

fn read_encoding(words: &mut Words<'_>) -> Result<Encoding, ParseError> {
    let word = words.some_word_on_line("a format")?;
    match word {
        b"ascii" => Ok(Encoding::Text),
        b"binary_little_endian" => Ok(Encoding::Little),
        b"binary_big_endian" => Ok(Encoding::Big),
        _ => Err(words.unexpected("ascii, binary_little_endian or binary_big_endian", word)),
    }
}

fn read_element(words: &mut Words<'_>) -> Result<Element, ParseError> {
    let name = shown(words.some_word_on_line("an element's name")?);
    let count = words.count_on_line("an element's count")?;
    let count = words.check_limit("elements", count)?;
    if name == "tristrips" {
        return Err(words.error(ErrorKind::Unsupported {
            what: "a PLY file of triangle strips".into(),
            mend: "export it with the element `face`",
        }));
    }
    let properties = Vec::new();
    Ok(Element {
        name,
        count,
        properties,
    })
}

fn read_property(words: &mut Words<'_>, elements: &mut [Element]) -> Result<(), ParseError> {
    let mut word = words.some_word_on_line("a property's type")?;
    let mut list = None;
    if word == b"list" {
        list = Some(read_kind(words)?);
        word = words.some_word_on_line("a list's type")?;
    }
    let kind = kind(word).ok_or_else(|| words.unexpected("a number type", word))?;
    let name = shown(words.some_word_on_line("a property's name")?);
    let Some(element) = elements.last_mut() else {
        return Err(words.unexpected("a line `element` before", b"property"));
    };
    element.properties.push(Property { name, list, kind });
    Ok(())
}

fn read_kind(words: &mut Words<'_>) -> Result<Scalar, ParseError> {
    let word = words.some_word_on_line("a number type")?;
    kind(word).ok_or_else(|| words.unexpected("a number type", word))
}

fn kind(word: &[u8]) -> Option<Scalar> {
    Some(match word {
        b"char" | b"int8" => Scalar::Int8,
        b"uchar" | b"uint8" => Scalar::UInt8,
        b"short" | b"int16" => Scalar::Int16,
        b"ushort" | b"uint16" => Scalar::UInt16,
        b"int" | b"int32" => Scalar::Int32,
        b"uint" | b"uint32" => Scalar::UInt32,
        b"float" | b"float32" => Scalar::Float32,
        b"double" | b"float64" => Scalar::Float64,
        _ => return None,
    })
}
