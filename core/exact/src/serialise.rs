//! Serialisation (feature `serde`) of a point set: the list of its points, validated anew when
//! read.

use crate::{Point, PointSet};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

impl Serialize for PointSet {
    /// Serialises the list of points.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.points().serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for PointSet {
    /// Deserialises a list of points and validates it: [`PointSet::new`].
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::new(Vec::<Point>::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}
