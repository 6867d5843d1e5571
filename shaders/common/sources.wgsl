// Which pixels holes are filled from. Twin: `FillSources` in src/engine/render/fill/mod.rs.

fn is_source(set_of: u32, pixel: u32) -> bool {
    let inverse_depth = depth_at(pixel);
    switch set_of {
        case ALL_SOURCES: { return inverse_depth >= 0.0; }
        case SURFACE_SOURCES: { return inverse_depth > 0.0 && !is_left_out(pixel); }
        default: { return inverse_depth != OPEN_HOLE; }
    }
}

// Whether a pixel's color may be blended with the sky, and there are others.
fn is_left_out(pixel: u32) -> bool {
    return knows_sky() && planes[pixel] == 1.0 && atomicLoad(&counts[SURFACES]) > atomicLoad(&counts[BLENDED_SURFACES]);
}

// Whether any hole is filled from a set.
fn is_asked(set_of: u32) -> bool {
    var kind = PLAIN_HOLES;
    if set_of == SURFACE_SOURCES {
        kind = HIDING_HOLES;
    } else if set_of == SOURCES_OF_OPEN {
        kind = OPEN_HOLES;
    }
    return has_filling() && atomicLoad(&counts[kind]) > 0u;
}
