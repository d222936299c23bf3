//! Names of groups in the field data of a `.vtu` file: an array by the name of each group, with
//! the number of the group and its dimension, as meshio has them for names of Gmsh's groups.

use crate::GroupName;
use crate::error::Reason;
use crate::text::{Tokens, integer};
use crate::xml::{attribute, malformed};
use quick_xml::escape::{escape, unescape};
use quick_xml::events::BytesStart;
use std::io::Write;

/// Writes the names, if there are some.
pub(super) fn write(out: &mut dyn Write, names: &[GroupName]) -> std::io::Result<()> {
    if names.is_empty() {
        return Ok(());
    }
    out.write_all(b"<FieldData>\n")?;
    for GroupName { dimension, group, name } in names {
        let plain: String = name.chars().filter(|c| !c.is_control()).collect();
        writeln!(
            out,
            "<DataArray type=\"Int64\" Name=\"{}\" NumberOfTuples=\"2\" format=\"ascii\">\n\
             {group} {dimension}\n</DataArray>",
            escape(plain.as_str())
        )?;
    }
    out.write_all(b"</FieldData>\n")
}

/// An array of field data that may be a name.
pub(super) struct Named {
    name: String,
    values: Vec<i64>,
}

impl Named {
    /// The array of an element; none if it holds no whole numbers as text.
    pub(super) fn of(element: &BytesStart<'_>) -> Result<Option<Self>, Reason> {
        let value = |name| attribute(element, name).map(Option::unwrap_or_default);
        let is_name = value("type")?.starts_with("Int")
            && value("format")? == "ascii"
            && value("NumberOfTuples")? == "2";
        let name = value("Name")?;
        let name = unescape(&name).map_err(|e| malformed(&e))?.into_owned();
        Ok((is_name && !name.is_empty()).then(|| Self { name, values: Vec::new() }))
    }

    /// Takes text of the array: of what is no name no more than tells that.
    pub(super) fn text(&mut self, text: &str) {
        let mut tokens = Tokens::new(text.as_bytes());
        while self.values.len() < 3
            && let Some(token) = tokens.next()
        {
            self.values.push(integer(token).unwrap_or(i64::MIN));
        }
    }

    /// The name, if it is one.
    pub(super) fn finish(self) -> Option<GroupName> {
        let &[group, dimension] = self.values.as_slice() else { return None };
        let dimension = u8::try_from(dimension).ok().filter(|d| matches!(d, 2 | 3))?;
        Some(GroupName { dimension, group, name: self.name })
    }
}
