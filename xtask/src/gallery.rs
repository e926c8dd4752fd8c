//! The papers' figures redone on generated surfaces: pictures and captions for the documentation.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use graticule_fixtures::{
    Fixture, block_with_holes, bumpy_patch, bumpy_sphere, grid, icosphere, torus, vase,
};

use crate::Trouble;
use crate::shrink::shrink;

/// Where the pictures go, and the page that shows them.
const PICTURES: &str = "docs/gallery";
const PAGE: &str = "docs/gallery.md";

/// Meshes that `graticule demo` writes.
const TEAPOT: &str = "teapot.obj";
const MASK: &str = "mask.obj";

/// What a figure is drawn on.
#[derive(Clone, Copy)]
enum Subject {
    /// A mesh that the demo writes.
    Demo(&'static str),
    /// A generated surface.
    Made(fn() -> Fixture),
}

/// A picture with what made it.
struct Figure {
    name: &'static str,
    /// The figure of the paper that it redoes.
    of: &'static str,
    subject: Subject,
    /// The command with its options, without files.
    command: &'static str,
    caption: &'static str,
}

const FIGURES: [Figure; 20] = [
    Figure {
        name: "overview",
        of: "PGP06, Fig. 1",
        subject: Subject::Demo(TEAPOT),
        command: "layout --grid-seams",
        caption: "From a surface to its charts, and a pattern that does not show where they meet.",
    },
    Figure {
        name: "norms",
        of: "PGP06, Fig. 5",
        subject: Subject::Made(revolution),
        command: "parameterize --method newton --draw-norms",
        caption: "Lines, the norm of the periodic variables and their energy: where lines end the norm is small and the energy high.",
    },
    Figure {
        name: "revolution-plain",
        of: "PGP06, Fig. 7A",
        subject: Subject::Made(revolution),
        command: "parameterize",
        caption: "Lines as far apart at the waists as at the belly: some have to end (blue).",
    },
    Figure {
        name: "revolution-scale",
        of: "PGP06, Fig. 7B",
        subject: Subject::Made(revolution),
        command: "field --curl-correction",
        caption: "The field, and the scale that takes its curl away: it grows where the radius falls.",
    },
    Figure {
        name: "revolution-corrected",
        of: "PGP06, Fig. 7C",
        subject: Subject::Made(revolution),
        command: "parameterize --curl-correction",
        caption: "With that scale no line ends.",
    },
    Figure {
        name: "spout-plain",
        of: "PGP06, Fig. 8, top",
        subject: Subject::Demo(TEAPOT),
        command: "parameterize --chart-size 6",
        caption: "Lines of one distance on parts of all widths.",
    },
    Figure {
        name: "spout-corrected",
        of: "PGP06, Fig. 8, bottom",
        subject: Subject::Demo(TEAPOT),
        command: "parameterize --chart-size 6 --curl-correction",
        caption: "Fewer of them end where their distance may change.",
    },
    Figure {
        name: "sphere-poles",
        of: "PGP06, Fig. 9A",
        subject: Subject::Made(sphere),
        command: "field --symmetry 1 --curvature-radius 0",
        caption: "A field of vectors: two poles of index 1.",
    },
    Figure {
        name: "sphere-half-poles",
        of: "PGP06, Fig. 9B",
        subject: Subject::Made(sphere),
        command: "field --symmetry 2 --curvature-radius 0",
        caption: "Lines: four of index 1/2.",
    },
    Figure {
        name: "sphere-quarter-poles",
        of: "PGP06, Fig. 9C",
        subject: Subject::Made(sphere),
        command: "field --symmetry 4 --curvature-radius 0",
        caption: "Crosses: eight of index 1/4.",
    },
    Figure {
        name: "genus",
        of: "PGP06, Fig. 11",
        subject: Subject::Made(block),
        command: "parameterize",
        caption: "Lines on a block of genus 3, along its edges.",
    },
    Figure {
        name: "scan",
        of: "PGP06, Fig. 12",
        subject: Subject::Made(scan),
        command: "parameterize --chart-size 8",
        caption: "Lines on a hundred thousand triangles with bumps of several sizes.",
    },
    Figure {
        name: "quads-coarse",
        of: "PGP06, Fig. 14",
        subject: Subject::Demo(TEAPOT),
        command: "remesh --quads 1000",
        caption: "A thousand quads.",
    },
    Figure {
        name: "quads-fine",
        of: "PGP06, Fig. 14",
        subject: Subject::Demo(TEAPOT),
        command: "remesh --quads 8000",
        caption: "Eight thousand.",
    },
    Figure {
        name: "anisotropic-edges",
        of: "PGP06, Fig. 16B",
        subject: Subject::Made(anisotropic_torus),
        command: "parameterize --energy edge --own-triangles --chart-count 100 --curvature-radius 0",
        caption: "A torus whose triangles are long around the tube's axis: the energy summed over edges sees them, and lines end.",
    },
    Figure {
        name: "anisotropic-triangles",
        of: "PGP06, Fig. 16C",
        subject: Subject::Made(anisotropic_torus),
        command: "parameterize --energy triangle --own-triangles --chart-count 100 --curvature-radius 0",
        caption: "The energy summed over triangles sees the shape: hardly a line ends.",
    },
    Figure {
        name: "irregular",
        of: "DMA02, Fig. 3",
        subject: Subject::Made(irregular),
        command: "flatten --method natural",
        caption: "The natural conformal map of an irregular mesh of a smooth surface.",
    },
    Figure {
        name: "natural",
        of: "DMA02, Fig. 5",
        subject: Subject::Demo(MASK),
        command: "flatten --method natural",
        caption: "The natural conformal map of a mask with open eyes and mouth.",
    },
    Figure {
        name: "near-optimal",
        of: "DMA02, Fig. 6",
        subject: Subject::Demo(MASK),
        command: "flatten --method optimal --functional area",
        caption: "The combination of the conformal and the authalic map that changes areas least.",
    },
    Figure {
        name: "boundary",
        of: "DMA02, Fig. 7",
        subject: Subject::Made(strip),
        command: "flatten --method boundary-optimal --functional symmetric-dirichlet",
        caption: "A strip of a sphere: the boundary, a circle at first, moves until the map is least distorted.",
    },
];

/// A surface of revolution with two waists.
fn revolution() -> Fixture {
    vase(0.55, 120, 110)
}

fn sphere() -> Fixture {
    icosphere(5)
}

fn block() -> Fixture {
    let coarse = block_with_holes(3);
    coarse.subdivided().subdivided().subdivided().subdivided()
}

fn scan() -> Fixture {
    bumpy_sphere(70)
}

/// A torus with triangles about eight times as long along the big circle as along the small one.
fn anisotropic_torus() -> Fixture {
    torus(1.0, 0.45, 36, 200)
}

fn irregular() -> Fixture {
    bumpy_patch(48, 7)
}

/// A strip along the equator of the unit sphere.
fn strip() -> Fixture {
    grid(4.2, 1.2, 84, 24).map(|p| {
        let (sin, cos) = libm::sincos(p.x);
        let (rise, wide) = libm::sincos(p.y - 0.6);
        glam::DVec3::new(cos * wide, sin * wide, rise)
    })
}

/// Draws every figure and writes the page.
pub(crate) fn run(root: &Path) -> Result<String, Trouble> {
    let program = crate::build_release(root)?;
    let folder = tempfile::tempdir().map_err(|error| Trouble(error.to_string()))?;
    let folder = folder.path();
    graticule(
        &program,
        folder,
        &["demo", "--quiet", "--output-folder", "."],
    )?;
    let pictures = root.join(PICTURES);
    fs::create_dir_all(&pictures).map_err(|error| Trouble::reading(&pictures, &error))?;
    for figure in &FIGURES {
        let mesh = match figure.subject {
            Subject::Demo(name) => name,
            Subject::Made(make) => {
                let path = folder.join("made.obj");
                fs::write(&path, make().to_obj())
                    .map_err(|error| Trouble::reading(&path, &error))?;
                "made.obj"
            }
        };
        let mut words: Vec<&str> = figure.command.split(' ').collect();
        words.extend([mesh, "-o", "out.obj", "--picture", "out.png", "--quiet"]);
        graticule(&program, folder, &words)?;
        let place = pictures.join(format!("{}.png", figure.name));
        shrink(&folder.join("out.png"), &place)?;
        eprintln!("{}", figure.name);
    }
    let page = root.join(PAGE);
    fs::write(&page, to_page()).map_err(|error| Trouble::reading(&page, &error))?;
    Ok(format!("{PAGE}: {} figures", FIGURES.len()))
}

fn graticule(program: &Path, folder: &Path, words: &[&str]) -> Result<(), Trouble> {
    let status = Command::new(program)
        .args(words)
        .current_dir(folder)
        .status()
        .map_err(|error| Trouble::reading(program, &error))?;
    if status.success() {
        Ok(())
    } else {
        Err(Trouble(format!("graticule {}: {status}", words.join(" "))))
    }
}

fn to_page() -> String {
    let mut text = String::from(
        "# Gallery\n\nFigures of the papers, redone on generated surfaces by `cargo xtask gallery`. \
         `teapot.obj` and `mask.obj` are those of `graticule demo`.\n",
    );
    for figure in &FIGURES {
        let mesh = match figure.subject {
            Subject::Demo(name) => name,
            Subject::Made(_) => "MESH",
        };
        let (command, options) = figure
            .command
            .split_once(' ')
            .unwrap_or((figure.command, ""));
        let line = format!("graticule {command} {mesh} -o OUT {options}");
        let _ = write!(
            text,
            "\n## {}\n\n![{}](gallery/{}.png)\n\n{}\n\n```\n{}\n```\n",
            figure.of,
            figure.caption,
            figure.name,
            figure.caption,
            line.trim_end()
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_has_a_name_of_its_own() {
        for (place, figure) in FIGURES.iter().enumerate() {
            assert!(
                FIGURES[..place]
                    .iter()
                    .all(|other| other.name != figure.name)
            );
        }
    }
}
