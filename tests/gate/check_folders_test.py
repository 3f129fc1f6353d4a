#!/usr/bin/env python3
"""Plants includes in a small made-up tree and looks at what scripts/check_folders says of each."""

import os
import subprocess
import sys
import tempfile

CHECK = sys.argv[1]

# file, include line, is it allowed?
CASES = [
    ("core/a.h", "#include <vector>", True),
    ("core/a.h", "#include <glm/vec3.hpp>", True),
    ("core/a.cpp", "#include <sys/mman.h>", True),
    ("core/a.h", '#include "core/scene.h"', True),
    ("core/a.h", '#include "net/link.h"', False),
    ("core/a.h", '# include "scene/load_scene.h"', False),
    ("core/a.h", "#include <net/link.h>", False),
    ("core/a.cpp", "#include <boost/asio/ip/udp.hpp>", False),
    ("core/a.cpp", "#include <Eigen/Dense>", False),
    ("core/a.cpp", "#include <spdlog/spdlog.h>", False),
    ("core/a.cpp", '#include "a.h"', False),
    ("core/deep/a.cpp", '#include "cli/options.h"', False),
    ("scene/a.cpp", "#include <google/protobuf/text_format.h>", True),
    ("scene/a.cpp", "#include <boost/asio.hpp>", False),
    ("net/a.cpp", "#include <boost/asio.hpp>", True),
    ("net/a.cpp", '#include "arch_central/central_loop.h"', False),
    ("arch_central/central_loop.h", '#include "net/link.h"', False),
    ("arch_central/server_node.h", '#include "net/link.h"', True),
    ("arch_distributed/replica_node.cpp", '#include "arch_central/server_law.h"', False),
    ("devices/a.cpp", '#include "net/link.h"', False),
    ("recording/a.cpp", "#include <hdf5.h>", True),
    ("core/a.cpp", "#include <hdf5.h>", False),
    ("analysis/a.h", "#include <Eigen/Dense>", True),
    ("analysis/a.h", '#include "net/state_codec.h"', False),
    ("cli/a.cpp", '#include "analysis/growth.h"', True),
    ("new_folder/a.cpp", "#include <vector>", False),
]


def main():
    wrong = 0
    for path, line, allowed in CASES:
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.join(root, os.path.dirname(path)))
            with open(os.path.join(root, path), "w", encoding="utf-8") as out:
                out.write(f"#pragma once\n{line}\n")
            run = subprocess.run([CHECK, root], capture_output=True, text=True, check=False)
            names_the_line = f"{path}:2" in run.stdout
            if (run.returncode == 0) != allowed or names_the_line == allowed:
                wrong += 1
                print(f"{path}: {line}: expected {'allowed' if allowed else 'refused'}")
                print(run.stdout + run.stderr)
    empty = tempfile.mkdtemp()
    if subprocess.run([CHECK, empty], capture_output=True, check=False).returncode == 0:
        wrong += 1
        print("a tree without any source file was called fine")
    os.rmdir(empty)
    print(f"{len(CASES) + 1} cases, {wrong} wrong")
    return 1 if wrong else 0


sys.exit(main())
