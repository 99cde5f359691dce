# The libraries airlight stands on, as AIR_LIBRARIES and AIR_SYSTEM_INCLUDES. Also used by the installed
# package, for those who link statically.

find_package(PkgConfig REQUIRED)
set(THREADS_PREFER_PTHREAD_FLAG ON)
find_package(Threads REQUIRED)
find_package(OpenMP REQUIRED COMPONENTS C)
find_package(OpenEXR 3.1 CONFIG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(EXPAT REQUIRED)
pkg_check_modules(JANSSON REQUIRED IMPORTED_TARGET jansson)
pkg_check_modules(BLOSC REQUIRED IMPORTED_TARGET blosc)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)

# Embree 3 is what Debian bookworm has; 4 is taken where only that is found.
find_package(embree 3 CONFIG QUIET)
if(NOT embree_FOUND)
    find_package(embree 4 CONFIG REQUIRED)
endif()

set(AIR_LIBRARIES embree OpenEXR::OpenEXRCore PkgConfig::JANSSON PkgConfig::BLOSC PkgConfig::ZSTD ZLIB::ZLIB EXPAT::EXPAT
    OpenMP::OpenMP_C Threads::Threads m)
