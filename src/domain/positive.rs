//! Whether a polynomial is positive all over a domain.
//!
//! The domain's box is halved until Bernstein's bounds or a corner tell: a box without negative
//! values is good; one where some is negative in the domain is not. What is left after the last
//! halving is so near to zero that it could only be told with more digits, and passes.

use crate::domain::error::DomainError;
use crate::domain::space::Domain;
use crate::domain::within::{holds_some, start_of_all};
use crate::integrals::bernstein::Bernstein;
use crate::integrals::polynomial::Polynomial;

/// A box is halved so often at most: thirty-two times along every axis.
const MOST_HALVINGS: u32 = 15;

/// Refuses a density that is not positive somewhere in the domain.
///
/// # Errors
/// [`DomainError::Density`] with a place.
pub(crate) fn check_positive(domain: &dyn Domain, density: &Polynomial) -> Result<(), DomainError> {
    let start = start_of_all(domain);
    let mut rest = vec![(Bernstein::new(density, &domain.bounds()), 0)];
    while let Some((part, halvings)) = rest.pop() {
        let [low, high] = part.range();
        if low >= 0.0 && high > 0.0 {
            continue;
        }
        let mut corners = part.corners();
        let refused = corners.find(|(corner, value)| {
            let is_good = value.is_finite() && *value >= 0.0;
            !is_good && domain.contains(corner)
        });
        if let Some((corner, value)) = refused {
            let position = corner.into();
            return Err(DomainError::Density { value, position });
        }
        if high <= 0.0 || halvings == MOST_HALVINGS {
            let is_bad = high <= 0.0 && holds_some(domain, &start, part.bounds());
            if is_bad {
                let (value, position) = (high, part.bounds().center().into());
                return Err(DomainError::Density { value, position });
            }
            continue;
        }
        let axis = part.steepest_axis();
        let halves = part.halves(axis).into_iter();
        rest.extend(halves.map(|half| (half, halvings + 1)));
    }
    Ok(())
}
