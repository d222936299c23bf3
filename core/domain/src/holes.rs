//! [`Holes`]: voids as users give them, beside what a file says.

use crate::{Domain, PrepareOptions};
use ltbw_exact::Point;
use std::fmt;
use std::str::FromStr;

/// The rule that says what is void in a domain.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Holes {
    /// The file's own: hole points, or the orientation of a surface.
    #[default]
    Given,
    /// Nothing.
    None,
    /// Bodies inside others, and what hole points of the file are in.
    Auto,
    /// The cells that these points are in, and hole points of the file.
    At(Vec<Point>),
}

impl Holes {
    /// Changes a domain and the options of its preparation accordingly.
    pub fn apply(&self, domain: &mut Domain, options: &mut PrepareOptions) {
        match self {
            Holes::Given => {}
            Holes::None => {
                domain.holes.clear();
                options.oriented = false;
            }
            Holes::Auto => options.nested_voids = true,
            Holes::At(points) => {
                domain.holes.extend(points);
                options.oriented = false;
            }
        }
    }
}

impl fmt::Display for Holes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let point = |[x, y, z]: &Point| format!("{x},{y},{z}");
        match self {
            Holes::Given => f.write_str("given"),
            Holes::None => f.write_str("none"),
            Holes::Auto => f.write_str("auto"),
            Holes::At(points) => {
                f.write_str(&points.iter().map(point).collect::<Vec<_>>().join(";"))
            }
        }
    }
}

impl FromStr for Holes {
    type Err = String;

    /// `none`, `auto`, or points: `X,Y,Z;X,Y,Z`.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "`none`, `auto`, or points as X,Y,Z;X,Y,Z".to_owned();
        let point = |text: &str| {
            let numbers: Result<Vec<f64>, _> =
                text.split(',').map(|number| number.trim().parse::<f64>()).collect();
            match numbers.map_err(|_| wrong())?[..] {
                [x, y, z] if [x, y, z].iter().all(|c| c.is_finite()) => Ok([x, y, z]),
                _ => Err(wrong()),
            }
        };
        match text.trim() {
            "none" => Ok(Holes::None),
            "auto" => Ok(Holes::Auto),
            points => {
                // A separator may end the list.
                let points = points.strip_suffix(';').unwrap_or(points);
                points.split(';').map(point).collect::<Result<_, _>>().map(Holes::At)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Holes;

    #[test]
    fn holes_are_told_by_a_word_or_by_points() {
        assert_eq!("none".parse(), Ok(Holes::None));
        assert_eq!("auto".parse(), Ok(Holes::Auto));
        assert_eq!("1,2,-3e1".parse(), Ok(Holes::At(vec![[1.0, 2.0, -30.0]])));
        let two = Holes::At(vec![[0.5, 0.0, 0.0], [1.0; 3]]);
        assert_eq!("0.5, 0, 0; 1,1,1".parse(), Ok(two.clone()));
        assert_eq!("0.5,0,0;1,1,1;".parse(), Ok(two));
        for wrong in ["", ";", "1,2", "1,2,3,4", "1,2,x", "1,2,nan", "1,2,inf", "all", "1,2,3;;"] {
            assert!(wrong.parse::<Holes>().is_err(), "{wrong}");
        }
    }
}
