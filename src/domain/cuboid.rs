//! The box as a domain, periodic along any subset of its axes.

use nalgebra::Point3;

use crate::arrays::MapEach;
use crate::domain::error::{DomainError, check_digits};
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::DomainShape;
use crate::geometry::bounds::Bounds;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;

/// An axis-aligned box; along a periodic axis opposite sides are the same place.
///
/// # Examples
/// ```
/// use chebloyd::{Bounds, Cuboid, DomainShape};
///
/// let channel = Cuboid::new(Bounds::from_corners([0.0; 3], [2.0, 1.0, 1.0]), [true, false, false])?;
/// assert!((channel.volume() - 2.0).abs() < 1e-15);
/// # Ok::<(), chebloyd::DomainError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    bounds: Bounds<3>,
    periodic: [bool; 3],
}

impl Cuboid {
    /// The box `bounds`, periodic along the axes marked.
    ///
    /// # Errors
    /// When a coordinate is not finite or an extent is not positive.
    pub fn new(bounds: Bounds<3>, periodic: [bool; 3]) -> Result<Self, DomainError> {
        let ends = bounds.min.iter().chain(bounds.max.iter());
        if let Some(&value) = ends.clone().find(|value| !value.is_finite()) {
            return Err(DomainError::NotFinite { value });
        }
        for axis in 0..3 {
            let (min, max) = (bounds.min[axis], bounds.max[axis]);
            if min >= max {
                return Err(DomainError::EmptyExtent { axis, min, max });
            }
        }
        if !bounds.volume().is_normal() {
            let volume = bounds.volume();
            return Err(DomainError::NoVolume { volume });
        }
        check_digits(&bounds)?;
        Ok(Self { bounds, periodic })
    }

    /// The walled cube [0, 1]³.
    #[must_use]
    pub fn unit() -> Self {
        let bounds = Bounds {
            min: Point3::origin(),
            max: Point3::new(1.0, 1.0, 1.0),
        };
        Self {
            bounds,
            periodic: [false; 3],
        }
    }
}

/// The label of the image of a site one period up or down along an axis.
fn image_label(site: u32, axis: usize, periods: i8) -> Label {
    let mut image = [0; 3];
    image[axis] = periods;
    FacetKind::Neighbor { site, image }.label()
}

impl DomainShape for Cuboid {
    fn bounds(&self) -> Bounds<3> {
        self.bounds
    }

    fn volume(&self) -> f64 {
        self.bounds.volume()
    }

    fn contains(&self, point: &Point3<f64>) -> bool {
        self.bounds.contains(point)
    }

    fn periods(&self) -> [Option<f64>; 3] {
        let extent = self.bounds.extent();
        [0, 1, 2].map_each(|axis| self.periodic[axis].then_some(extent[axis]))
    }

    fn is_box(&self) -> bool {
        true
    }

    fn start(&self, site: &Point3<f64>, index: u32, cell: &mut Polyhedron) {
        let mut around = Bounds::empty();
        let mut labels = [0; 6];
        for axis in 0..3 {
            let [below, above] = [2 * axis, 2 * axis + 1];
            if self.periodic[axis] {
                // Half-way to the site's own images.
                let half = 0.5 * (self.bounds.max[axis] - self.bounds.min[axis]);
                (around.min[axis], around.max[axis]) = (-half, half);
                labels[below] = image_label(index, axis, -1);
                labels[above] = image_label(index, axis, 1);
            } else {
                around.min[axis] = self.bounds.min[axis] - site[axis];
                around.max[axis] = self.bounds.max[axis] - site[axis];
                labels[below] = FacetKind::Wall(below as u32).label();
                labels[above] = FacetKind::Wall(above as u32).label();
            }
        }
        cell.assign_cuboid(&around, labels);
    }
}
