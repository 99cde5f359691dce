# The targets a newcomer needs; CMake does the work (CMakePresets.json). `make help` lists them.

BUILD := build/release
JOBS := $(shell nproc)
PREFIX ?= /usr/local
CTEST := ctest --test-dir $(BUILD) --output-on-failure --no-tests=error -j $(JOBS)

.PHONY: help setup build demo test test-long bench check format install clean

help:
	@echo "make demo       install what is missing, build, render a scene to demo.exr and demo.png"
	@echo "make test       install what is missing, build, run the tests"
	@echo "make test-long  the tests that take minutes"
	@echo "make build      build only: $(BUILD)/airlight"
	@echo "make bench      build and run the benchmarks"
	@echo "make check      format, layers, public headers"
	@echo "make format     format the sources (clang-format 14)"
	@echo "make install    install to PREFIX (default $(PREFIX))"
	@echo "make clean      remove build/"

setup:
	@tools/setup.sh

build:
	@mkdir -p build
	@cmake --preset release $(CMAKE_FLAGS) >build/configure.log 2>&1 || { cat build/configure.log; exit 1; }
	cmake --build --preset release -j $(JOBS)

demo: setup
	@$(MAKE) --no-print-directory build
	$(BUILD)/airlight render scenes/sunroom/sunroom.gltf --width 800 --spp 64 -o demo.exr -o demo.png
	@echo "The picture: $(CURDIR)/demo.png (to look at), $(CURDIR)/demo.exr (linear light)"

test: setup
	@$(MAKE) --no-print-directory build
	@$(CTEST) -L unit

test-long: setup
	@$(MAKE) --no-print-directory build
	@$(CTEST) -L long

bench: setup
	@$(MAKE) --no-print-directory build
	cmake --build --preset release --target bench
	python3 bench/roombeam.py --airlight $(BUILD)/airlight

check:
	@tools/setup.sh --check
	@$(MAKE) --no-print-directory build
	@$(CTEST) -L check

format:
	@tools/format.sh

install: build
	cmake --install $(BUILD) --prefix $(PREFIX)

clean:
	rm -rf build
