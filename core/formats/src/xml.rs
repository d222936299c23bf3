//! The XML of VTK's files: its events, one after the other, and the attributes of elements.

use super::error::{ParseError, Reason, excerpt, one_line};
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

/// Goes through the events of the XML that the first `length` bytes of a file are, each with its
/// offset.
///
/// # Errors
/// What is not text or not well-formed; those of `each`.
pub(crate) fn each_event<'a>(
    bytes: &'a [u8],
    length: usize,
    mut each: impl FnMut(Event<'a>, usize) -> Result<(), ParseError>,
) -> Result<(), ParseError> {
    let text = std::str::from_utf8(&bytes[..length]).map_err(|e| {
        ParseError::at(bytes, e.valid_up_to(), Reason::Syntax("not UTF-8 text".into()))
    })?;
    let mut reader = Reader::from_str(text);
    // Every event but the last consumes at least a byte.
    loop {
        let offset = reader.buffer_position() as usize;
        match reader.read_event() {
            Ok(Event::Eof) => return Ok(()),
            Ok(event) => each(event, offset)?,
            Err(e) => {
                let offset = reader.error_position() as usize;
                return Err(ParseError::at(bytes, offset, malformed(&e)));
            }
        }
    }
}

/// The complaint of the XML parser, cut to a line.
pub(crate) fn malformed(error: &dyn std::error::Error) -> Reason {
    Reason::Syntax(format!("not well-formed XML: {}", one_line(&error.to_string(), 120)))
}

/// The value of an attribute, if the element has it.
pub(crate) fn attribute(element: &BytesStart<'_>, name: &str) -> Result<Option<String>, Reason> {
    match element.try_get_attribute(name) {
        Ok(Some(a)) => Ok(Some(a.value.trim().to_owned())),
        Ok(None) => Ok(None),
        Err(e) => Err(malformed(&e)),
    }
}

/// Refuses an outermost element that is not that of VTK's files of a kind.
pub(crate) fn expect_kind(element: &BytesStart<'_>, wanted: &str) -> Result<(), Reason> {
    if element.name().into_inner() != "VTKFile" {
        return Err(Reason::Syntax("not a VTK file".into()));
    }
    let kind = attribute(element, "type")?.unwrap_or_default();
    if kind != wanted {
        let text = format!("a VTK file of type `{}`", excerpt(kind.as_bytes()));
        return Err(Reason::Unsupported(text));
    }
    Ok(())
}
