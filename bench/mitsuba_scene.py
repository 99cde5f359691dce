"""Mitsuba scenes of the older dialects as Mitsuba 3 reads them, with a film and an integrator of
one's own. Needs NumPy."""

import os
import re
import xml.etree.ElementTree as ElementTree

import numpy as np

MEDIA = {"sigmaA": "sigma_a", "sigmaS": "sigma_s", "sigmaT": "sigma_t"}


def _numbers(text):
    return np.array([float(x) for x in re.split(r"[,\s]+", text.strip())])


def _take(element, name):
    """The numbers of a child, which is taken out; None if there is none of that name."""
    for child in list(element):
        if MEDIA.get(child.get("name"), child.get("name")) == name and child.get("value"):
            element.remove(child)
            return _numbers(child.get("value"))
    return None


def _text(values):
    return ", ".join(repr(float(v)) for v in np.broadcast_to(values, 3))


def _homogeneous(medium):
    """Coefficients as extinction, up to 1 times a scale, and albedo; true where the extinction has a
    colour."""
    absorbed, scattered = _take(medium, "sigma_a"), _take(medium, "sigma_s")
    if scattered is None:
        return False
    extinction = np.broadcast_to(scattered + absorbed, 3)
    albedo = np.divide(scattered, extinction, out=np.zeros(3), where=extinction > 0)
    scale = _take(medium, "scale")
    scale = extinction.max() * (1.0 if scale is None else scale[0])
    ElementTree.SubElement(medium, "float", name="scale", value=repr(float(scale)))
    for name, values in (("sigma_t", extinction / extinction.max()), ("albedo", albedo)):
        ElementTree.SubElement(medium, "rgb", name=name, value=_text(values))
    return bool(np.ptp(extinction) > 0)


def _volume(path, folder):
    """A grid without negative values, which Mitsuba does not mind, whose box is larger by half a
    cell on each side: its first and last values lie on the sides, as they did in the older dialects.
    Path and number of channels."""
    with open(path, "rb") as file:
        data = file.read()
    size, channels = np.frombuffer(data, "<i4", 3, 8), int(np.frombuffer(data, "<i4", 1, 20)[0])
    box = np.frombuffer(data, "<f4", 6, 24).astype(np.float64).reshape(2, 3)
    margin = (box[1] - box[0]) / np.maximum(size - 1, 1) / 2.0
    box = np.stack([box[0] - margin, box[1] + margin]).astype("<f4")
    values = np.maximum(np.frombuffer(data, "<f4", offset=48), 0.0)
    out = os.path.join(folder, os.path.basename(path))
    with open(out, "wb") as file:
        file.write(data[:24] + box.tobytes() + values.astype("<f4").tobytes())
    return out, channels


def _heterogeneous(medium, folder):
    coloured = False
    for child in list(medium):
        if child.get("name") in ("method", "stepSize"):
            medium.remove(child)
        if child.tag == "volume":
            density = child.get("name") == "density"
            child.set("name", "sigma_t" if density else child.get("name"))
            for file in child.findall("string[@name='filename']"):
                path, channels = _volume(file.get("value"), folder)
                file.set("value", path)
                coloured = coloured or (density and channels == 3)
                ElementTree.SubElement(child, "boolean", name="use_grid_bbox", value="true")
                ElementTree.SubElement(child, "boolean", name="raw", value="true")
    return coloured


def _open_boundaries(root):
    """Shapes without a material that part media are not there for light; Mitsuba 3 wants it said."""
    for shape in root.iter("shape"):
        parts = [c for c in shape if c.get("name") in ("interior", "exterior")]
        known = {b.get("id") for b in root.iter("bsdf")}
        given = [c for c in shape if c.tag == "bsdf" or (c.tag == "ref" and c.get("id") in known)]
        if parts and not given and shape.find("emitter") is None:
            ElementTree.SubElement(shape, "bsdf", type="null")


def _grey_spectra(root):
    """One value for all wavelengths was grey in the older dialects; now it is white of equal
    energy, which has a colour."""
    for spectrum in root.iter("spectrum"):
        value = spectrum.get("value", "")
        if int(root.get("version", "0").split(".")[0]) < 2 and re.fullmatch(r"[-+.\deE]+", value):
            spectrum.tag = "rgb"
            spectrum.set("value", _text(float(value)))


def _name(root, name):
    """A parameter's name in the dialect of the scene."""
    modern = int(root.get("version", "0").split(".")[0]) >= 2
    return re.sub(r"[A-Z]", lambda m: "_" + m[0].lower(), name) if modern else name


def _film(root, sensor, width, height):
    for child in list(sensor):
        if child.tag in ("film", "sampler"):
            sensor.remove(child)
    film = ElementTree.SubElement(sensor, "film", type="hdrfilm")
    for name, value in (("width", width), ("height", height)):
        ElementTree.SubElement(film, "integer", name=name, value=str(value))
    for name, value in (("pixelFormat", "rgb"), ("componentFormat", "float32")):
        ElementTree.SubElement(film, "string", name=_name(root, name), value=value)
    ElementTree.SubElement(film, "rfilter", type="box")
    ElementTree.SubElement(sensor, "sampler", type="independent")


def _read(path):
    """A scene with what it includes, less what Mitsuba 3 does not know and pictures do not need."""
    root = ElementTree.parse(path).getroot()
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag == "include":
                at = list(parent).index(child)
                parent.remove(child)
                included = os.path.join(os.path.dirname(path), child.get("filename"))
                parent[at:at] = list(ElementTree.parse(included).getroot())
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag == "mode" or child.get("name") == "maxSmoothAngle":
                parent.remove(child)
            if child.tag == "lookAt":
                child.tag = "lookat"
    return root


def film_size(path):
    """Width and height that a scene asks for, and how many events it counts (None: all)."""
    root = _read(path)
    defaults = {d.get("name"): d.get("value") for d in root.iter("default")}

    def number(name):
        for element in root.iter("integer"):
            if element.get("name") in (name, re.sub(r"[A-Z]", lambda m: "_" + m[0].lower(), name)):
                text = element.get("value")
                return int(defaults[text[1:]] if text.startswith("$") else text)
        return None

    depth = number("maxDepth")
    return number("width"), number("height"), None if depth in (None, -1) else depth - 1


def thinner(path, out, factor):
    """Writes a scene whose media with a scale above 1 have so many times less of everything; for
    scenes without further files."""
    tree = ElementTree.parse(path)
    for medium in tree.getroot().iter("medium"):
        for scale in medium.findall("float[@name='scale']"):
            if float(scale.get("value")) > 1.0:
                scale.set("value", repr(float(scale.get("value")) / factor))
    tree.write(out)


def two_sided(path, out):
    """Writes a scene whose materials reflect on both sides; for scenes without further files."""
    tree = ElementTree.parse(path)
    for bsdf in tree.getroot().findall("bsdf"):
        inner = ElementTree.Element("bsdf", type=bsdf.get("type"))
        inner[:] = bsdf[:]
        bsdf[:] = [inner]
        bsdf.set("type", "twosided")
    tree.write(out)


def write(path, out, width, height, depth):
    """Writes a scene for Mitsuba 3 to `out`; depth: events that are counted at most, None: all."""
    folder = os.path.dirname(os.path.abspath(out))
    root = _read(path)
    for element in root.iter():
        if element.get("name") == "filename":
            element.set("value", os.path.join(os.path.dirname(path), element.get("value")))
    coloured = False
    for medium in root.iter("medium"):
        kind = medium.get("type")
        coloured |= kind == "homogeneous" and _homogeneous(medium)
        coloured |= kind == "heterogeneous" and _heterogeneous(medium, folder)
    _open_boundaries(root)
    _grey_spectra(root)
    for child in list(root):
        if child.tag == "integrator":
            root.remove(child)
    media = root.find(".//medium") is not None
    kind = "volpathmis" if coloured else "volpath" if media else "path"
    integrator = ElementTree.SubElement(root, "integrator", type=kind)
    limit = -1 if depth is None else depth + 1
    ElementTree.SubElement(integrator, "integer", name=_name(root, "maxDepth"), value=str(limit))
    for sensor in root.iter("sensor"):
        _film(root, sensor, width, height)
    ElementTree.ElementTree(root).write(out)
