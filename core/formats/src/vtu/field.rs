//! An array of points that is asked for: the field of a solution.

use super::{Reason, attribute, excerpt, is_single};
use quick_xml::events::BytesStart;

/// The array that is asked for.
pub(super) struct Asked {
    /// Its name, if one was given.
    name: Option<String>,
    /// The name of the one that was found.
    found: Option<String>,
}

impl Asked {
    pub(super) fn new(name: Option<&str>) -> Self {
        Self { name: name.map(ToOwned::to_owned), found: None }
    }

    /// Is an array of points the one that is asked for, if one is?
    pub(super) fn is(
        this: &mut Option<Self>,
        own: &str,
        element: &BytesStart<'_>,
    ) -> Result<bool, Reason> {
        let Some(asked) = this else { return Ok(false) };
        if let Some(name) = &asked.name {
            let components = attribute(element, "NumberOfComponents")?;
            return match (name == own, components.as_deref()) {
                (false, _) => Ok(false),
                (true, None | Some("1")) => Ok(true),
                (true, Some(count)) => {
                    let (own, count) = (excerpt(own.as_bytes()), excerpt(count.as_bytes()));
                    let text = format!("the array `{own}` has {count} numbers for each point");
                    Err(Reason::Unsupported(text))
                }
            };
        }
        if own == "tag" || !is_single(element)? {
            return Ok(false);
        }
        let found = asked.found.get_or_insert_with(|| own.to_owned());
        if found.as_str() == own {
            return Ok(true);
        }
        let [found, own] = [found.as_str(), own].map(|name| excerpt(name.as_bytes()));
        let text = format!("the arrays `{found}` and `{own}` of points: one has to be named");
        Err(Reason::Unsupported(text))
    }
}

/// Why there is no such array.
pub(super) fn missing(name: Option<&str>) -> Reason {
    Reason::Syntax(match name {
        Some(name) => format!("points without the array `{}`", excerpt(name.as_bytes())),
        None => "points without an array of floats, one each".to_owned(),
    })
}
