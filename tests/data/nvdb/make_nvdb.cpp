// Makes the .nvdb files beside it. They were made with Debian bookworm's libopenvdb-dev and
// libnanovdb-dev 10.0.1:
//
//     g++ -std=c++17 -O1 -DNANOVDB_USE_ZIP -DNANOVDB_USE_BLOSC make_nvdb.cpp -lopenvdb -ltbb
//     -lImath -lz -lblosc -o make_nvdb
//     ./make_nvdb
//
// The values are what tests/test_media_grid_nvdb.c expects: pattern(i, j, k) on [-3,6] x [0,9] x
// [2,5].

#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

using Handle = nanovdb::GridHandle<nanovdb::HostBuffer>;
using nanovdb::io::Codec;

static float pattern(int i, int j, int k)
{
    return 1.0f + float((3 * i + 5 * j + 7 * k) & 15) / 16.0f;
}

// index (i, j, k) lies at 0.25 (i, j, k) + (1, 2, 3)
template <typename Grid> static void place(Grid &grid, const char *name)
{
    grid.setTransform(openvdb::math::Transform::createLinearTransform(0.25));
    grid.transform().postTranslate(openvdb::Vec3d(1, 2, 3));
    grid.setGridClass(openvdb::GRID_FOG_VOLUME);
    grid.setName(name);
}

template <typename Grid, typename Value>
static typename Grid::Ptr fill(const char *name, Value value)
{
    typename Grid::Ptr grid = Grid::create();
    auto accessor = grid->getAccessor();
    for (int i = -3; i <= 6; i++) {
        for (int j = 0; j <= 9; j++) {
            for (int k = 2; k <= 5; k++) {
                accessor.setValue(openvdb::Coord(i, j, k), value(i, j, k));
            }
        }
    }
    place(*grid, name);
    return grid;
}

static void write(const char *path, std::vector<Handle> handles, Codec codec)
{
    nanovdb::io::writeGrids(path, handles, codec);
}

template <typename Build, typename Grid> static Handle convert(const Grid &grid)
{
    return nanovdb::openToNanoVDB<nanovdb::HostBuffer, typename Grid::TreeType, Build>(grid);
}

template <typename... Handles> static std::vector<Handle> list(Handles &&...handles)
{
    std::vector<Handle> out;
    (out.push_back(std::move(handles)), ...);
    return out;
}

int main()
{
    openvdb::initialize();
    const auto density = fill<openvdb::FloatGrid>("density", pattern);
    const auto warm = fill<openvdb::FloatGrid>("warm", [](int, int, int) { return 300.0f; });
    const auto doubles = fill<openvdb::DoubleGrid>("density", pattern);
    const auto ids = fill<openvdb::Int32Grid>("ids", [](int i, int, int) { return i; });
    const auto color = fill<openvdb::Vec3SGrid>("albedo", [](int i, int j, int k) {
        return openvdb::Vec3s(pattern(i, j, k), 0.5f, pattern(k, j, i));
    });
    const auto damaged = fill<openvdb::FloatGrid>("density", pattern);
    damaged->getAccessor().setValue(openvdb::Coord(4, 5, 3), NAN);
    damaged->getAccessor().setValue(openvdb::Coord(-2, 1, 2), -1.0f);
    const auto negative = fill<openvdb::FloatGrid>("density", pattern);
    negative->getAccessor().setValue(openvdb::Coord(-2, 1, 2), -1.0f);

    // one tile of 8^3 and one of 128^3, besides a voxel
    openvdb::FloatGrid::Ptr tiles = openvdb::FloatGrid::create();
    tiles->tree().addTile(1, openvdb::Coord(8, 0, 0), 0.5f, true);
    tiles->tree().addTile(2, openvdb::Coord(-128, 0, 0), 2.0f, true);
    tiles->tree().setValue(openvdb::Coord(3, 3, 3), 0.25f);
    place(*tiles, "density");

    const auto sphere =
        openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(2.0f, openvdb::Vec3f(0), 1.0f);
    sphere->setName("density");

    write("zip.nvdb", list(convert<float>(*density)), Codec::ZIP);
    write("blosc.nvdb", list(convert<float>(*density)), Codec::BLOSC);
    write("double.nvdb", list(convert<double>(*doubles)), Codec::ZIP);
    write("vec3f.nvdb", list(convert<nanovdb::Vec3f>(*color)), Codec::ZIP);
    write("fp4.nvdb", list(convert<nanovdb::Fp4>(*density)), Codec::ZIP);
    write("fp8.nvdb", list(convert<nanovdb::Fp8>(*density)), Codec::ZIP);
    write("fp16.nvdb", list(convert<nanovdb::Fp16>(*density)), Codec::ZIP);
    write("fpn.nvdb", list(convert<nanovdb::FpN>(*density)), Codec::ZIP);
    write("several.nvdb",
          list(convert<int32_t>(*ids), convert<float>(*warm), convert<float>(*density)),
          Codec::ZIP);
    write("ids.nvdb", list(convert<int32_t>(*ids)), Codec::ZIP);
    write("tiles.nvdb", list(convert<float>(*tiles)), Codec::ZIP);
    write("level_set.nvdb", list(convert<float>(*sphere)), Codec::ZIP);
    write("nan.nvdb", list(convert<float>(*damaged)), Codec::ZIP);
    write("negative.nvdb", list(convert<float>(*negative)), Codec::ZIP);
    return 0;
}
