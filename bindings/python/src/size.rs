//! Wanted edge lengths: a number, an array at the vertices of the surface or of a mesh, or a Python
//! function of the place.

use crate::failure::Failure;
use crate::supervise::look;
use ltbw::{Observer, Point, Progress};
use ltbw_bindings::{Class, Field, PATIENCE, Ready, Reins};
use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// A wish of edge lengths.
#[derive(FromPyObject)]
pub(crate) enum Size {
    /// One for all places.
    Constant(f64),
    /// One for each vertex of the surface.
    Vertices(Vec<f64>),
    /// One for each point of a mesh: points, tetrahedra, lengths.
    OnMesh(Vec<Point>, Vec<[u32; 4]>, Vec<f64>),
    /// A function of the place.
    Function(Py<PyAny>),
}

impl Size {
    /// The sizes of a number or of an array; `None` for a function.
    pub(crate) fn field(&self, ready: &Ready) -> Result<Option<Box<Field<'static>>>, Failure> {
        match self {
            Self::Constant(length) => {
                let length = checked(*length, None)?;
                Ok(Some(Box::new(move |_| length)))
            }
            Self::Vertices(sizes) => Ok(Some(ready.sizes(sizes)?)),
            Self::OnMesh(points, tets, sizes) => {
                Ok(Some(ready.sizes_on(points.clone(), tets.clone(), sizes)?))
            }
            Self::Function(_) => Ok(None),
        }
    }
}

/// A length, or why it is none.
fn checked(length: f64, at: Option<Point>) -> Result<f64, Failure> {
    // An infinite length asks for nothing.
    if length > 0.0 {
        return Ok(length);
    }
    let place = at.map(|p| format!(" at {p:?}")).unwrap_or_default();
    let text = format!("size{place} is {length:?}; an edge length is positive");
    Err(Failure::new(Class::Input, "size.value", text))
}

/// A Python function that is asked by the thread which called us. After its first exception it is
/// asked no more: the work is cancelled, and the exception goes back.
pub(crate) struct Function<'a> {
    function: &'a Py<PyAny>,
    offset: Point,
    reins: &'a Reins,
    tell: Option<&'a Py<PyAny>>,
    raised: Mutex<Option<Failure>>,
    looked: Mutex<Instant>,
}

impl<'a> Function<'a> {
    pub(crate) fn new(
        function: &'a Py<PyAny>,
        offset: Point,
        reins: &'a Reins,
        tell: Option<&'a Py<PyAny>>,
    ) -> Self {
        let (raised, looked) = (Mutex::new(None), Mutex::new(Instant::now()));
        Self { function, offset, reins, tell, raised, looked }
    }

    /// The length at a place; infinite, which asks for nothing, once something was raised.
    pub(crate) fn at(&self, p: Point) -> f64 {
        if self.reins.cancel.is_cancelled() {
            return f64::INFINITY;
        }
        let place = [0, 1, 2].map(|k| p[k] + self.offset[k]);
        let asked = Python::attach(|py| {
            self.look(py)?;
            let length: f64 =
                self.function.call1(py, (<(f64, f64, f64)>::from(place),))?.extract(py)?;
            checked(length, Some(place))
        });
        asked.unwrap_or_else(|failure| {
            self.fails(failure);
            f64::INFINITY
        })
    }

    /// Cancels the work for an exception, which goes back when the work has ended.
    fn fails(&self, failure: Failure) {
        self.reins.cancel.cancel();
        let mut raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        raised.get_or_insert(failure);
    }

    /// Looks for signals and tells the progress, now and then.
    fn look(&self, py: Python<'_>) -> Result<(), Failure> {
        let mut looked = self.looked.lock().unwrap_or_else(PoisonError::into_inner);
        if looked.elapsed() < PATIENCE {
            return Ok(());
        }
        *looked = Instant::now();
        drop(looked);
        Ok(look(py, self.reins, self.tell)?)
    }

    /// The exception, if one was raised.
    pub(crate) fn raised(self) -> Option<Failure> {
        self.raised.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Work that asks for no sizes for a while is watched all the same.
impl Observer for Function<'_> {
    fn progress(&self, progress: Progress) {
        self.reins.progress.progress(progress);
        if !self.reins.cancel.is_cancelled() {
            Python::attach(|py| self.look(py)).unwrap_or_else(|failure| self.fails(failure));
        }
    }
}
