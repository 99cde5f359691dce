// airlight-vdb2nvdb: converts the float and Vec3f grids of an OpenVDB file to NanoVDB, which
// airlight reads.
//
//     airlight-vdb2nvdb IN.vdb OUT.nvdb [GRIDNAME]
//
// Level sets become fog volumes. With GRIDNAME only grids of that name are taken. Built where
// OpenVDB is installed.

#include <cstdio>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetUtil.h>

#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

namespace
{

using Handle = nanovdb::GridHandle<nanovdb::HostBuffer>;

#ifdef NANOVDB_USE_ZIP
constexpr nanovdb::io::Codec codec = nanovdb::io::Codec::ZIP;
#else
constexpr nanovdb::io::Codec codec = nanovdb::io::Codec::NONE;
#endif

// Converts one grid; false, with a line on stderr, if airlight has no use for its kind of values.
bool convert(const openvdb::GridBase::Ptr &base, std::vector<Handle> &handles)
{
    const std::string what = "\"" + base->getName() + "\" (" + base->valueType() + ")";
    if (openvdb::FloatGrid::Ptr grid = openvdb::GridBase::grid<openvdb::FloatGrid>(base)) {
        if (grid->getGridClass() == openvdb::GRID_LEVEL_SET) {
            std::cerr << "airlight-vdb2nvdb: grid " << what
                      << " is a level set, made a fog volume\n";
            openvdb::tools::sdfToFogVolume(*grid);
        }
        handles.push_back(nanovdb::openToNanoVDB(*grid));
    } else if (openvdb::Vec3SGrid::Ptr vectors =
                   openvdb::GridBase::grid<openvdb::Vec3SGrid>(base)) {
        handles.push_back(nanovdb::openToNanoVDB(*vectors));
    } else {
        std::cerr << "airlight-vdb2nvdb: grid " << what
                  << " left out, expected float or vec3s values\n";
        return false;
    }
    std::cerr << "airlight-vdb2nvdb: grid " << what << ", " << base->activeVoxelCount()
              << " active voxels\n";
    return true;
}

std::vector<Handle> convertFile(const std::string &path, const std::string &wanted)
{
    openvdb::io::File file(path);
    std::vector<Handle> handles;
    std::string names;
    file.open();
    const openvdb::GridPtrVecPtr grids = file.getGrids();
    for (const openvdb::GridBase::Ptr &grid : *grids) {
        names += (names.empty() ? "\"" : ", \"") + grid->getName() + "\"";
        if (wanted.empty() || wanted == grid->getName()) {
            convert(grid, handles);
        }
    }
    if (handles.empty()) {
        throw std::runtime_error("no grid " +
                                 (wanted.empty() ? std::string() : "\"" + wanted + "\" ") +
                                 "with float or vec3s values; the file holds " +
                                 (names.empty() ? std::string("none") : names));
    }
    return handles;
}

// Writes beside the final name, then renames: the file appears whole or not at all.
void writeFile(const std::string &path, const std::vector<Handle> &handles)
{
    const std::string temporary = path + ".partial";
    try {
        nanovdb::io::writeGrids(temporary, handles, codec);
    } catch (...) {
        std::remove(temporary.c_str());
        throw;
    }
    if (std::rename(temporary.c_str(), path.c_str()) != 0) {
        std::remove(temporary.c_str());
        throw std::runtime_error("cannot rename " + temporary + " to " + path);
    }
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 3 && argc != 4) {
        std::cerr << "usage: airlight-vdb2nvdb IN.vdb OUT.nvdb [GRIDNAME]\n";
        return 2;
    }
    const char *place = argv[1];
    try {
        openvdb::initialize();
        const std::vector<Handle> handles = convertFile(argv[1], argc == 4 ? argv[3] : "");
        place = argv[2];
        writeFile(argv[2], handles);
    } catch (const std::exception &error) {
        std::cerr << "airlight-vdb2nvdb: " << place << ": " << error.what() << "\n";
        return 1;
    }
    return 0;
}
