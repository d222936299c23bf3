//! Groups of the faces of a surface: the solids of an `.stl` file, the groups and materials of an
//! `.obj` file, colours. Each is a marker with a name, if there are several.

use crate::GroupName;
use crate::error::one_line;
use ltbw_domain::Domain;
use std::collections::HashMap;

/// The most groups of a surface; more say nothing of its parts.
const MOST: usize = 1000;

/// Characters of a name.
const LONGEST: usize = 80;

/// The number of no group.
const NONE: u32 = u32::MAX;

/// Groups while faces are read.
#[derive(Debug, Default)]
pub(crate) struct Groups {
    names: Vec<String>,
    numbers: HashMap<String, u32>,
    /// The group of each face.
    of: Vec<u32>,
    /// The group of the faces that follow.
    now: Option<u32>,
    /// A group of all faces is a body, and its name that of the volume.
    are_bodies: bool,
}

/// A name from the words of a file.
pub(crate) fn name(words: &[u8]) -> String {
    let text = String::from_utf8_lossy(words);
    let words: Vec<&str> = text.split_whitespace().collect();
    one_line(&words.join(" ").replace('"', "'"), LONGEST)
}

impl Groups {
    /// Groups that are bodies where there is one.
    pub(crate) fn of_bodies() -> Self {
        Self { are_bodies: true, ..Self::default() }
    }

    /// Begins a group, or goes on with it; one without a name is none.
    pub(crate) fn begin(&mut self, name: &str) {
        self.now = (!name.is_empty()).then(|| self.number(name));
    }

    fn number(&mut self, name: &str) -> u32 {
        // Groups beyond the most count once, for all.
        let next = self.names.len().min(MOST + 1) as u32;
        if let Some(&number) = self.numbers.get(name) {
            return number;
        }
        if self.names.len() <= MOST {
            self.names.push(name.to_owned());
            self.numbers.insert(name.to_owned(), next);
        }
        next.min(MOST as u32)
    }

    /// Puts the faces up to this number, which have no group yet, into that which has begun.
    pub(crate) fn take(&mut self, faces: usize) {
        self.of.resize(faces, self.now.unwrap_or(NONE));
    }

    /// The number of groups that faces are in, those in none being one.
    fn count(&self) -> usize {
        let mut used = self.of.clone();
        used.sort_unstable();
        used.dedup();
        used.len()
    }

    fn name_of(&self, face: usize) -> &str {
        self.names.get(self.of[face] as usize).map_or("", String::as_str)
    }

    /// These groups, each divided by others of the same faces: where only one of both divides
    /// anything, it alone.
    pub(crate) fn divided(self, by: Self) -> Self {
        match (self.count() > 1, by.count() > 1) {
            (_, false) => self,
            (false, true) => by,
            (true, true) => {
                let mut both = Self::default();
                for face in 0..self.of.len().min(by.of.len()) {
                    let name = [self.name_of(face), by.name_of(face)];
                    let name: Vec<&str> =
                        name.into_iter().filter(|name| !name.is_empty()).collect();
                    both.begin(&name.join("/"));
                    both.take(face + 1);
                }
                both
            }
        }
    }

    /// Gives the facets of a domain their groups as markers, from 1 in the order of the file, and
    /// returns the names. Facets that are all in one group have no markers; of a body its name is
    /// that of the volume. Too many groups are none, and a note says so.
    pub(crate) fn mark(self, domain: &mut Domain, notes: &mut Vec<String>) -> Vec<GroupName> {
        let group = |(group, name)| GroupName { dimension: 2, group, name };
        if self.names.len() > MOST {
            notes.push(format!("more than {MOST} groups or colours of faces are no parts"));
            return Vec::new();
        }
        if self.count() < 2 {
            let volume = |name| GroupName { dimension: 3, group: 1, name };
            return self
                .names
                .into_iter()
                .filter(|_| self.are_bodies)
                .take(1)
                .map(volume)
                .collect();
        }
        // Numbers of those that have faces.
        let mut used = vec![false; self.names.len()];
        self.of.iter().for_each(|&g| used.get_mut(g as usize).into_iter().for_each(|u| *u = true));
        let mut next = 0;
        let markers: Vec<i32> = used
            .iter()
            .map(|&is_used| {
                next += i32::from(is_used);
                if is_used { next } else { 0 }
            })
            .collect();
        for (facet, &own) in domain.facets.iter_mut().zip(&self.of) {
            facet.marker = markers.get(own as usize).copied().unwrap_or(0);
        }
        let named = markers.iter().map(|&m| i64::from(m)).zip(self.names);
        named.filter(|(marker, _)| *marker > 0).map(group).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ltbw_domain::Facet;

    fn marked(groups: Groups, facets: usize) -> (Vec<i32>, Vec<(u8, i64, String)>, usize) {
        let facet = Facet::polygon(&[0, 1, 2], 0);
        let mut domain = Domain { facets: vec![facet; facets], ..Domain::default() };
        let mut notes = Vec::new();
        let names = groups.mark(&mut domain, &mut notes);
        let names = names.into_iter().map(|n| (n.dimension, n.group, n.name)).collect();
        (domain.facets.iter().map(|f| f.marker).collect(), names, notes.len())
    }

    fn groups(names: &[&str]) -> Groups {
        let mut groups = Groups::default();
        for (k, name) in names.iter().enumerate() {
            groups.begin(name);
            groups.take(k + 1);
        }
        groups
    }

    #[test]
    fn groups_are_markers_in_the_order_of_the_file() {
        let mut two = groups(&["a", "", "b", "a"]);
        two.begin("without faces");
        let names = vec![(2, 1, "a".to_owned()), (2, 2, "b".to_owned())];
        assert_eq!(marked(two, 4), (vec![1, 0, 2, 1], names, 0));
        assert_eq!(marked(groups(&["a", "a"]), 2), (vec![0; 2], vec![], 0));
        let body = Groups { are_bodies: true, ..groups(&["a", "a"]) };
        assert_eq!(marked(body, 2), (vec![0; 2], vec![(3, 1, "a".to_owned())], 0));
    }

    #[test]
    fn materials_divide_groups() {
        let both = groups(&["a", "a", "b"]).divided(groups(&["x", "y", ""]));
        let names: Vec<String> = marked(both, 3).1.into_iter().map(|n| n.2).collect();
        assert_eq!(names, ["a/x", "a/y", "b"]);
        let one = groups(&["a", "a"]).divided(groups(&["x", "y"]));
        assert_eq!(marked(one, 2).1[1].2, "y");
        let other = groups(&["a", "b"]).divided(groups(&["x", "x"]));
        assert_eq!(marked(other, 2).1[1].2, "b");
    }

    #[test]
    fn too_many_groups_are_none() {
        let names: Vec<String> = (0..=MOST + 5).map(|k| format!("{k}")).collect();
        let all: Vec<&str> = names.iter().map(String::as_str).collect();
        let (markers, names, notes) = marked(groups(&all), all.len());
        assert!(markers.iter().all(|&m| m == 0) && names.is_empty() && notes == 1);
        assert_eq!(marked(groups(&all[..MOST]), MOST).1.len(), MOST);
    }

    #[test]
    fn names_are_one_line_of_plain_words() {
        assert_eq!(name(b"  the\tlong \"name\" "), "the long 'name'");
        assert_eq!(name(&[b'x'; 200]).len(), LONGEST + 3);
    }
}
