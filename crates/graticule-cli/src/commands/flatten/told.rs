//! What the options of `graticule flatten` tell of single points: how it is written.

use glam::DVec2;
use serde::Serialize;

/// A vertex of the file with its place in the plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Pin {
    pub(super) vertex: u32,
    pub(super) place: DVec2,
}

/// A vertex of the file with a number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Told {
    pub(super) vertex: u32,
    pub(super) number: f64,
}

/// A point of the surface: a weighted mean of up to three vertices of the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Point(pub(super) Vec<(u32, f64)>);

/// A point with its place in the plane.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Place {
    pub(super) point: Point,
    pub(super) place: DVec2,
}

/// Two points with their places.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Line {
    pub(super) ends: [Point; 2],
    pub(super) places: [DVec2; 2],
}

fn point(text: &str) -> Option<Point> {
    let term = |text: &str| match text.split_once('*') {
        Some((vertex, weight)) => {
            let weight: f64 = weight.trim().parse().ok()?;
            let usable = weight.is_finite() && weight >= 0.0;
            usable.then_some((vertex.trim().parse().ok()?, weight))
        }
        None => Some((text.trim().parse().ok()?, 1.0)),
    };
    let terms: Vec<(u32, f64)> = text.split('+').map(term).collect::<Option<_>>()?;
    let total: f64 = terms.iter().map(|term| term.1).sum();
    let sound = terms.len() <= 3 && (total - 1.0).abs() < 1e-6;
    sound.then_some(Point(terms))
}

fn place(text: &str) -> Option<DVec2> {
    let (u, v) = text.split_once(',')?;
    let place = DVec2::new(u.trim().parse().ok()?, v.trim().parse().ok()?);
    place.is_finite().then_some(place)
}

pub(super) fn parse_pin(text: &str) -> Result<Pin, String> {
    let parse = || {
        let (vertex, at) = text.split_once(':')?;
        Some(Pin {
            vertex: vertex.trim().parse().ok()?,
            place: place(at)?,
        })
    };
    parse().ok_or_else(|| "not of the form VERTEX:U,V, such as 12:0.5,1".into())
}

pub(super) fn parse_told(text: &str) -> Result<Told, String> {
    let parse = || {
        let (vertex, number) = text.split_once(':')?;
        let number: f64 = number.trim().parse().ok()?;
        let vertex = vertex.trim().parse().ok()?;
        number.is_finite().then_some(Told { vertex, number })
    };
    parse().ok_or_else(|| "not of the form VERTEX:NUMBER, such as 12:90".into())
}

pub(super) fn parse_place(text: &str) -> Result<Place, String> {
    let parse = || {
        let (of, at) = text.split_once(':')?;
        Some(Place {
            point: point(of)?,
            place: place(at)?,
        })
    };
    parse().ok_or_else(|| {
        "not of the form POINT:U,V, such as 12:0.5,1 or 4*0.2+9*0.5+7*0.3:0.5,1 with weights of \
         sum 1"
            .into()
    })
}

pub(super) fn parse_line(text: &str) -> Result<Line, String> {
    let parse = || {
        let [from, to, start, end] = text.split(':').collect::<Vec<_>>().try_into().ok()?;
        Some(Line {
            ends: [point(from)?, point(to)?],
            places: [place(start)?, place(end)?],
        })
    };
    parse().ok_or_else(|| "not of the form POINT:POINT:U,V:U,V, such as 3:90:0,0:1,0".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pins_are_a_vertex_and_two_finite_numbers() {
        let pin = parse_pin("12:-0.5,1e3").unwrap();
        assert_eq!((pin.vertex, pin.place), (12, DVec2::new(-0.5, 1000.0)));
        for text in ["12", "12:1", "x:1,2", "1:nan,0", "-1:0,0", "1:0,0,0"] {
            assert!(parse_pin(text).is_err(), "{text}");
        }
    }

    #[test]
    fn points_are_vertices_or_means_of_three() {
        let at = parse_place("4*0.25+9*0.5+7*0.25:1,-2").unwrap();
        assert_eq!(at.point.0, [(4, 0.25), (9, 0.5), (7, 0.25)]);
        assert_eq!(at.place, DVec2::new(1.0, -2.0));
        assert_eq!(parse_place("4:0,0").unwrap().point.0, [(4, 1.0)]);
        for text in [
            "4*0.5:0,0",
            "4+5:0,0",
            "4*2+5*-1:0,0",
            "4",
            "4*x+5*0.5:0,0",
            "4:0",
        ] {
            assert!(parse_place(text).is_err(), "{text}");
        }
        let line = parse_line("4:9*0.5+8*0.5:0,0:1,0").unwrap();
        assert_eq!(line.ends[1].0, [(9, 0.5), (8, 0.5)]);
        assert_eq!(line.places[1], DVec2::X);
        assert!(parse_line("4:9:0,0").is_err());
        assert!((parse_told("7:-90").unwrap().number + 90.0).abs() < 1e-12);
        assert!(parse_told("7:inf").is_err());
    }
}
