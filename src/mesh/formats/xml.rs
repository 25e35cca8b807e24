//! The part of XML that VTK's files need: tags with attributes, and the text after them.
//!
//! Entities are not decoded and nothing is validated: VTK writes neither entities nor CDATA
//! among numbers. Comments and `<?…?>` are passed over.

/// An opening or closing tag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Tag<'a> {
    /// The element's name, with a leading `/` for a closing tag.
    pub(crate) name: &'a [u8],
    /// All between the name and the closing bracket.
    attributes: &'a [u8],
    /// Where the text after the tag starts.
    pub(crate) end: usize,
}

impl<'a> Tag<'a> {
    /// The value of an attribute.
    pub(crate) fn attribute(&self, name: &str) -> Option<&'a [u8]> {
        let mut rest = self.attributes;
        loop {
            let equals = find(rest, b"=")?;
            let key = rest[..equals].trim_ascii();
            rest = rest[equals + 1..].trim_ascii_start();
            let quote = *rest
                .first()
                .filter(|&&byte| byte == b'"' || byte == b'\'')?;
            let length = rest[1..].iter().position(|&byte| byte == quote)?;
            if key == name.as_bytes() {
                return Some(&rest[1..=length]);
            }
            rest = &rest[length + 2..];
        }
    }

    /// The text of the element up to the next tag, none if the element ends with its opening tag.
    pub(crate) fn content(&self, bytes: &'a [u8]) -> &'a [u8] {
        if self.attributes.ends_with(b"/") {
            return b"";
        }
        let rest = &bytes[self.end..];
        &rest[..find(rest, b"<").unwrap_or(rest.len())]
    }
}

/// The first tag at or after `position`.
pub(crate) fn next_tag(bytes: &[u8], mut position: usize) -> Option<Tag<'_>> {
    loop {
        let start = position + find(bytes.get(position..)?, b"<")? + 1;
        let rest = &bytes[start..];
        if rest.starts_with(b"!--") {
            position = start + find(rest, b"-->")?;
            continue;
        }
        let length = closing_bracket(rest)?;
        position = start + length + 1;
        if rest.starts_with(b"?") || rest.starts_with(b"!") {
            continue;
        }
        return Some(tag_of(&rest[..length], position));
    }
}

/// The tag with the text `inside` its brackets, which ends at `end`.
fn tag_of(inside: &[u8], end: usize) -> Tag<'_> {
    let ends_name = |byte: &u8| byte.is_ascii_whitespace();
    let split = inside.iter().position(ends_name).unwrap_or(inside.len());
    let (name, attributes) = inside.split_at(split);
    Tag {
        name,
        attributes,
        end,
    }
}

/// The first `>` outside quotes.
fn closing_bracket(bytes: &[u8]) -> Option<usize> {
    let mut quote = None;
    bytes.iter().position(|&byte| {
        match quote {
            Some(open) if byte == open => quote = None,
            None if byte == b'"' || byte == b'\'' => quote = Some(byte),
            _ => {}
        }
        quote.is_none() && byte == b'>'
    })
}

fn find(bytes: &[u8], pattern: &[u8]) -> Option<usize> {
    bytes
        .windows(pattern.len())
        .position(|window| window == pattern)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_and_comments() {
        let text = b"<?xml version='1.0'?><!-- <no a='1'> --><yes a = \"x>y\" b='2'>7<z/>8";
        let tag = next_tag(text, 0).unwrap();
        assert_eq!(
            (tag.name, tag.attribute("a"), tag.attribute("b")),
            (&b"yes"[..], Some(&b"x>y"[..]), Some(&b"2"[..]))
        );
        assert!(tag.attribute("c").is_none());
        assert_eq!(tag.content(text), b"7");
        let next = next_tag(text, tag.end).unwrap();
        assert_eq!((next.name, next.content(text)), (&b"z/"[..], &b"8"[..]));
    }
}
