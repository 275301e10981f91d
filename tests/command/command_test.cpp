#include "tests/command/command.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

// Runs the built command as a user would.

namespace boxunion {
namespace {

using namespace std::string_literals;

constexpr const char* kHeader = "xmin,ymin,zmin,xmax,ymax,zmax\n";

TEST_F(Command, HelpAndVersionAreResults) {
  Outcome r = run("--version");
  EXPECT_EQ(r.status, 0);
  EXPECT_TRUE(r.out.starts_with("boxunion "));
  for (const char* help :
       {"--help", "measure --help", "combine --help", "generate --help", "generate cubes --help"}) {
    r = run(help);
    EXPECT_EQ(r.status, 0);
    EXPECT_NE(r.out.find("Usage: boxunion"), std::string::npos);
    EXPECT_EQ(r.err, "");
  }
}

TEST_F(Command, WrongUsageExitsWith2) {
  expect_error("", 2, "A subcommand is required");
  expect_error("measure", 2, "FILE is required");
  expect_error("boundary a.csv", 2, "--output is required");
  expect_error("measure a.csv --fast", 2, "The following argument was not expected: --fast");
  expect_error("measure a.csv --method magic", 2, "--method: magic not in {auto,cells,slices}");
  expect_error("measure a.csv --threads -1", 2,
               "--threads: found \"-1\", expected a whole number from 0 to 4096");
  expect_error("generate cubes --count 1 --edge 0 -o a.csv", 2, "edge is 0, expected 1 to 32768");
  expect_error("generate sponge --level 15 -o a.csv", 2, "level is 15, expected 0 to 14");
  EXPECT_EQ(folder_.file_count(), 0u);
}

TEST_F(Command, BadInputExitsWith3) {
  const std::string expected_text =
      "; expected the header xmin,ymin,zmin,xmax,ymax,zmax or lines of six numbers";
  expect_error("measure none.csv", 3, "none.csv: cannot read: No such file or directory");
  folder_.write("empty.csv", "");
  expect_error("measure empty.csv", 3, "empty.csv: no boxes: the file is empty" + expected_text);
  expect_error("measure - < /dev/null", 3, "standard input: no boxes: the file is empty" + expected_text);
  folder_.write("few.csv", kHeader + "0,0,0,1,1\n"s);
  expect_error("measure few.csv", 3, "few.csv:2: found 5 columns, expected 6: xmin,ymin,zmin,xmax,ymax,zmax");
  folder_.write("many.csv", kHeader + "0,0,0,1,1,1,7\n"s);
  expect_error("measure many.csv", 3,
               "many.csv:2: found 7 columns, expected 6: xmin,ymin,zmin,xmax,ymax,zmax");
  folder_.write("text.csv", kHeader + "0,0,0,1,1,1\n0,0,0,1,one,1\n"s);
  expect_error("measure text.csv", 3, "text.csv:3: ymax is \"one\", expected a number");
  folder_.write("nan.csv", "0,0,0,1,1,1\nnan,0,0,1,1,1\n");
  expect_error("measure nan.csv", 3, "nan.csv:2: xmin is nan, expected a finite number");
  expect_error("measure - < nan.csv", 3, "standard input:2: xmin is nan, expected a finite number");
  folder_.write("inf.csv", "0,0,0,1,1,inf\n");
  expect_error("measure inf.csv", 3, "inf.csv:1: zmax is inf, expected a finite number");
  folder_.write("reversed.csv", "0,0,0,1,1,1\n0,2,0,1,1,1\n");
  expect_error("measure reversed.csv", 3, "reversed.csv:2: ymin is 2 and ymax is 1, expected ymin <= ymax");
  expect_error("measure boxes.txt", 3,
               "boxes.txt: unknown extension .txt, expected .csv, .npy, .nrrd, .nhdr, .mha, .mhd, .tif, "
               ".tiff or .vox");

  const auto npy = [&](const std::string& name, const std::string& dictionary, std::size_t bytes) {
    folder_.write(name,
                  "\x93NUMPY\1\0"s + char(dictionary.size()) + '\0' + dictionary + std::string(bytes, '\0'));
  };
  npy("shape.npy", "{'descr': '<f8', 'fortran_order': False, 'shape': (6, 2), }\n", 96);
  expect_error("measure shape.npy", 3,
               "shape.npy: found an array of shape (6, 2), expected (n, 6), or (z, y, x) for voxels");
  npy("type.npy", "{'descr': '<c16', 'fortran_order': False, 'shape': (1, 6), }\n", 96);
  expect_error(
      "measure type.npy", 3,
      "type.npy: found numbers of type <c16, expected float64 (f8), float32 (f4), int32 (i4) or int64 (i8)");
  npy("short.npy", "{'descr': '<f8', 'fortran_order': True, 'shape': (3, 6), }\n", 96);
  expect_error("measure short.npy", 3,
               "short.npy: the file is cut off: the header says 3 rows, found the bytes of 2");
}

TEST_F(Command, OutputThatCannotBeWrittenExitsWith3BeforeAnythingElse) {
  folder_.write("file", "");
  expect_error("boundary none.csv -o out.xyz", 3,
               "out.xyz: unknown extension .xyz, expected .csv, .npy, .obj, .ply, .off, .stl or .3mf");
  expect_error("generate sponge --level 1 -o out.obj", 3,
               "out.obj: unknown extension .obj, expected .csv or .npy");
  expect_error("boundary none.csv -o none/out.csv", 3,
               "none/out.csv: cannot create the file: none does not exist");
  expect_error("boundary none.csv -o file/out.csv", 3,
               "file/out.csv: cannot create the file: file is not a folder");
  expect_error("boundary none.csv -o /proc/out.csv", 3,
               "/proc/out.csv: cannot create the file: No such file or directory");
  expect_error("generate sponge --level 1 -o none/out.npy", 3,
               "none/out.npy: cannot create the file: none does not exist");
}

TEST_F(Command, AFailedRunLeavesTheOldOutput) {
  folder_.write("out.csv", "old");
  folder_.write("bad.csv", "0,0,0,1,1\n");
  expect_error("boundary bad.csv -o out.csv", 3,
               "bad.csv:1: found 5 columns, expected 6: xmin,ymin,zmin,xmax,ymax,zmax");
  EXPECT_EQ(folder_.read("out.csv"), "old");
  EXPECT_EQ(folder_.file_count(), 2u);
}

TEST_F(Command, AnUnknownDeviceExitsWith4) {
  folder_.write("a.csv", "0,0,0,1,1,1\n");
  const Outcome r = run("measure a.csv --device abacus");
  EXPECT_EQ(r.status, 4);
  EXPECT_EQ(r.out, "");
  EXPECT_TRUE(r.err.starts_with("boxunion: error: ")) << r.err;
  EXPECT_NE(r.err.find("abacus"), std::string::npos) << r.err;
}

TEST_F(Command, AFullDiskExitsWith5AndLeavesNothing) {
  const Outcome full = shell("trap '' XFSZ; ulimit -f 8; boxunion generate sponge --level 4 -o out.npy");
  EXPECT_EQ(full.status, 5);
  EXPECT_EQ(full.err, "boxunion: error: out.npy: cannot write: File too large\n");
  EXPECT_EQ(folder_.file_count(), 0u);
  run("generate sponge --level 3 -o a.npy");
  for (const std::string memory : {"", " --memory 110M"}) {
    const Outcome mesh = shell("trap '' XFSZ; ulimit -f 8; boxunion boundary a.npy -o out.3mf" + memory);
    EXPECT_EQ(mesh.status, 5) << mesh.err;
    EXPECT_EQ(folder_.file_count(), 1u);
  }
  expect_error("devices --json > /dev/full", 5, "standard output: cannot write: No space left on device");
}

TEST_F(Command, AnInterruptExitsWith130AndLeavesNothing) {
  const Outcome r = shell(
      "timeout --foreground --preserve-status -s INT 1 "
      "boxunion generate sponge --level 14 -o out.csv");
  EXPECT_EQ(r.status, 130);
  EXPECT_EQ(r.err, "boxunion: error: interrupted\n");
  EXPECT_EQ(folder_.file_count(), 0u);
}

TEST_F(Command, GeneratedBoxesAreTheSameInEveryFormat) {
  EXPECT_EQ(json("generate cubes --count 3 --edge 10 --universe 100 --seed 7 -o a.csv --json"),
            (nlohmann::json{{"boxes", 3}, {"output", "a.csv"}}));
  EXPECT_EQ(run("generate checkerboard --size 3 -o c.csv").out, "boxes   14\noutput  c.csv\n");
  EXPECT_EQ(run("generate boxes --count 2 --min-edge 0 --max-edge 4 -o b.npy --quiet").status, 0);
  EXPECT_EQ(folder_.read("c.csv").substr(0, 56), kHeader + "0,0,0,1,1,1\n2,0,0,3,1,1\n1,"s);
  EXPECT_EQ(folder_.read("b.npy").size(), 128u + 2 * 24);
}

TEST_F(Command, AnEmptyUnionIsAllZeros) {
  folder_.write("header.csv", kHeader);
  const nlohmann::json result = json("measure header.csv --json");
  for (const char* key :
       {"boxes", "degenerate_boxes", "volume", "area", "edge_length", "vertices", "extreme_vertices"})
    EXPECT_EQ(result.at(key), 0) << key;
  EXPECT_EQ(result.at("bounds"), nlohmann::json({{0, 0, 0}, {0, 0, 0}}));
  EXPECT_EQ(json("boundary header.csv -o v.csv --json").at("vertices"), 0);
  EXPECT_EQ(folder_.read("v.csv"),
            "x,y,z,mask,degree_px,degree_nx,degree_py,degree_ny,degree_pz,degree_nz\n");
}

TEST_F(Command, MeasurePrintsTheKeysOfTheContract) {
  folder_.write("a.csv", "0,0,0,1,2,3\n0,0,0,0,5,5\n");
  const nlohmann::json result = json("measure a.csv --json --device native --threads 1");
  std::vector<std::string> keys;
  for (const auto& [key, value] : result.items()) keys.push_back(key);
  EXPECT_EQ(keys, (std::vector<std::string>{"area", "bounds", "boxes", "centroid", "degenerate_boxes",
                                            "device", "edge_length", "extreme_vertices", "inertia", "kernel",
                                            "method", "seconds", "vertices", "volume"}));
  EXPECT_EQ(result.at("boxes"), 2);
  EXPECT_EQ(result.at("degenerate_boxes"), 1);
  EXPECT_EQ(result.at("method"), "staircase");
  EXPECT_EQ(result.at("device"), "native");
  EXPECT_TRUE(result.at("seconds").contains("total"));
  EXPECT_EQ(result.at("volume"), 6);
  EXPECT_EQ(result.at("area"), 22);
  EXPECT_EQ(result.at("edge_length"), 24);
  EXPECT_EQ(result.at("bounds"), nlohmann::json({{0, 0, 0}, {1, 2, 3}}));
  EXPECT_EQ(result.at("centroid"), nlohmann::json({0.5, 1, 1.5}));
  EXPECT_EQ(result.at("inertia"), nlohmann::json({{6.5, 0, 0}, {0, 5, 0}, {0, 0, 2.5}}));
  EXPECT_EQ(result.at("vertices"), 8);
  EXPECT_EQ(result.at("extreme_vertices"), 8);

  const Outcome table = run("measure a.csv");
  EXPECT_EQ(table.status, 0);
  EXPECT_TRUE(table.out.starts_with("boxes             2\ndegenerate boxes  1\nbounds            0 0 0\n"))
      << table.out;
}

TEST_F(Command, MeasurePrintsStatistics) {
  folder_.write("a.csv", "0,0,0,5,5,5\n2,3,4,8,9,10\n0,0,0,0,5,5\n");
  for (const std::string kernel : {"occupancy", "faces"}) {
    const nlohmann::json result =
        json("measure a.csv --statistics --json --device native --kernel " + kernel);
    EXPECT_EQ(result.at("kernel"), kernel);
    EXPECT_EQ(result.at("statistics"), nlohmann::json({{"cells", 1},
                                                       {"covered_cells", 0},
                                                       {"cell_box_overlaps", 2},
                                                       {"box_volume_sum", 341},
                                                       {"box_area_sum", 366},
                                                       {"box_edge_length_sum", 132},
                                                       {"input_vertices", 16},
                                                       {"visible_input_vertices", 14},
                                                       {"edge_face_vertices", 6},
                                                       {"three_face_vertices", 0},
                                                       {"other_vertices", 0}}));
  }
  const std::string table = run("measure a.csv --statistics").out;
  EXPECT_NE(table.find("\ncell box overlaps       2\n"), std::string::npos) << table;
  EXPECT_NE(table.find("\nedge face vertices      6\n"), std::string::npos) << table;
  EXPECT_FALSE(json("measure a.csv --statistics --json --method slices").at("statistics").contains("cells"));
}

TEST_F(Command, OutOfMemoryExitsWith5AndSaysHowMuchWasNeeded) {
  if (sanitized()) GTEST_SKIP() << "sanitizers reserve more than any limit";
  ASSERT_EQ(run("generate cubes --count 5000000 --edge 30 -o big.npy --quiet").status, 0);
  // the first limit is too low for the file of 120 MB, the second for the boxes beside it
  for (const auto& [kilobytes, what] :
       {std::pair{"115000", "big.npy needs 120000000"}, {"200000", "sorting the boxes into tiles needs "}}) {
    const Outcome r =
        shell("ulimit -v "s + kilobytes + "; boxunion measure big.npy --device native --threads 2");
    EXPECT_EQ(r.status, 5);
    EXPECT_EQ(r.out, "");
    EXPECT_TRUE(r.err.starts_with("boxunion: error: out of memory: "s + what)) << r.err;
    EXPECT_NE(r.err.find(" bytes"), std::string::npos) << r.err;
  }
}

TEST_F(Command, AnInterruptedRunLeavesTheOldOutput) {
  ASSERT_EQ(run("generate cubes --count 5000000 --edge 30 -o big.npy --quiet").status, 0);
  folder_.write("out.csv", "old");
  for (const std::string& seconds : interrupt_times()) {
    const Outcome r = shell("timeout --foreground --preserve-status -k 30 -s INT " + seconds +
                            " boxunion boundary big.npy -o out.csv --device native");
    EXPECT_EQ(r.status, 130);
    EXPECT_EQ(r.err, "boxunion: error: interrupted\n");
    EXPECT_EQ(folder_.read("out.csv"), "old");
    EXPECT_EQ(folder_.file_count(), 2u);
  }
}

TEST_F(Command, BoundaryWritesTheVertices) {
  folder_.write("a.csv", "0,0,0,1,2,3.25\n");
  const nlohmann::json result = json("boundary a.csv -o v.csv --json");
  EXPECT_EQ(result.at("vertices"), 8);
  EXPECT_EQ(result.at("output"), "v.csv");
  EXPECT_EQ(
      folder_.read("v.csv"),
      "x,y,z,mask,degree_px,degree_nx,degree_py,degree_ny,degree_pz,degree_nz\n"
      "0,0,0,128,0,1,0,1,0,1\n1,0,0,64,1,0,0,1,0,1\n0,2,0,32,0,1,1,0,0,1\n1,2,0,16,1,0,1,0,0,1\n"
      "0,0,3.25,8,0,1,0,1,1,0\n1,0,3.25,4,1,0,0,1,1,0\n0,2,3.25,2,0,1,1,0,1,0\n1,2,3.25,1,1,0,1,0,1,0\n");
  EXPECT_EQ(run("boundary a.csv -o v.npy").status, 0);
  EXPECT_EQ(folder_.read("v.npy").size(), 192u + 8 * 31);
}

TEST_F(Command, BoundaryPrintsTheKeysOfTheContract) {
  // Two pairs of cubes, one touching along an edge, one at a vertex.
  folder_.write("a.csv", "0,0,0,1,1,1\n1,1,0,2,2,1\n5,0,0,6,1,1\n6,1,1,7,2,2\n");
  const auto counts = [&](const std::string& arguments) {
    nlohmann::json result = json("boundary a.csv --json " + arguments);
    for (const char* key : {"method", "kernel", "device", "seconds", "output"})
      EXPECT_EQ(result.erase(key), 1u);
    return result;
  };
  const nlohmann::json expected = {{"vertices", 29}, {"edges", 47}, {"nonmanifold_edges", 1},
                                   {"faces", 24},    {"holes", 0},  {"shells", 4},
                                   {"cavities", 0},  {"bodies", 4}, {"triangles", 48}};
  for (const char* file : {"v.csv", "v.npy", "m.obj", "m.ply", "m.off", "m.stl", "m.3mf"})
    for (const char* contacts : {"", " --nonmanifold keep", " --nonmanifold split"})
      EXPECT_EQ(counts("-o "s + file + contacts), expected) << file << contacts;
  EXPECT_NE(run("boundary a.csv -o m.ply").out.find("\nnonmanifold edges  1\n"), std::string::npos);

  const auto points = [&](const std::string& arguments) {
    EXPECT_EQ(run("boundary a.csv -o m.off " + arguments).status, 0);
    return folder_.read("m.off").substr(0, 12);
  };
  EXPECT_EQ(points(""), "OFF\n29 48 0\n");
  EXPECT_EQ(points("--nonmanifold split"), "OFF\n32 48 0\n");
  run("boundary a.csv -o polygons.obj");
  run("boundary a.csv -o triangles.obj --triangles");
  EXPECT_LT(folder_.read("polygons.obj").size(), folder_.read("triangles.obj").size());
}

TEST_F(Command, CombinePrintsWhatMeasurePrintsAndWritesWhatBoundaryWrites) {
  folder_.write("a.csv", "0,0,0,4,4,4\n0,0,0,4,0,4\n");
  folder_.write("b.csv", "1,1,1,2,2,5\n");
  // a block with a pit, as boxes without holes
  folder_.write("same.csv", "0,0,0,4,4,1\n0,0,0,1,4,4\n2,0,0,4,4,4\n0,0,0,4,1,4\n0,2,0,4,4,4\n");
  const auto without = [](nlohmann::json result, std::initializer_list<const char*> keys) {
    for (const char* key : keys) EXPECT_EQ(result.erase(key), 1u) << key;
    return result;
  };
  const nlohmann::json result = json("combine 'A not B' A=a.csv B=b.csv --json");
  EXPECT_EQ(result.at("expression"), "A not B");
  EXPECT_EQ(result.at("sets"), nlohmann::json({{"A", {{"file", "a.csv"}, {"boxes", 2}}},
                                               {"B", {{"file", "b.csv"}, {"boxes", 1}}}}));
  EXPECT_EQ(result.at("boxes"), 3);
  EXPECT_EQ(result.at("degenerate_boxes"), 1);
  EXPECT_EQ(without(result, {"expression", "sets", "boxes", "degenerate_boxes", "seconds"}),
            without(json("measure same.csv --json"), {"boxes", "degenerate_boxes", "seconds"}));

  for (const std::string output : {"v.csv", "v.npy", "m.obj", "m.ply", "m.stl", "m.3mf"}) {
    const nlohmann::json combined = json("combine 'A not B' A=a.csv B=b.csv --json -o combined_" + output);
    const nlohmann::json expected = json("boundary same.csv --json -o " + output);
    for (const char* key : {"vertices", "edges", "faces", "holes", "shells", "triangles"})
      EXPECT_EQ(combined.at(key), expected.at(key)) << key;
    EXPECT_EQ(combined.at("volume"), 61);
    EXPECT_EQ(folder_.read("combined_" + output), folder_.read(output));
  }
  EXPECT_EQ(json("combine 'A not B' A=a.csv B=b.csv --json --boxes c.npy").at("boxes_output"), "c.npy");
  EXPECT_EQ(json("measure c.npy --json").at("volume"), 61);
  const Outcome table = run("combine 'A and not(B or C)' A=a.csv B=b.csv C=- < b.csv");
  EXPECT_EQ(table.status, 0);
  EXPECT_TRUE(
      table.out.starts_with("expression        A and not(B or C)\nsets              A: 2 boxes of a.csv\n"
                            "                  B: 1 boxes of b.csv\n"))
      << table.out;
}

TEST_F(Command, CombineSaysWhatIsWrong) {
  folder_.write("a.csv", "0,0,0,4,4,4\n");
  expect_error("combine", 2, "EXPRESSION is required");
  expect_error("combine A", 2, "NAME=FILE is required");
  expect_error("combine 'A and' A=a.csv", 2, "expression, column 6: expected a name or '(', found the end");
  expect_error("combine 'A or Q' A=a.csv", 2, "expression, column 6: Q is not given: expected Q=FILE");
  expect_error("combine A A", 2, "\"A\": expected NAME=FILE");
  expect_error("combine A or=a.csv", 2, "\"or=a.csv\": an expression has no such name");
  expect_error("combine A A=a.csv A=a.csv", 2, "A is given twice");
  expect_error("combine 'A or B' A=- B=-", 2, "standard input can be only one of the sets");
  expect_error("combine A A=a.csv --triangles", 2, "--triangles requires --output");
  expect_error("combine 'A or B' A=a.csv B=none.csv -o v.csv", 3,
               "none.csv: cannot read: No such file or directory");
  expect_error("combine 'A not B' A=a.csv B=a.csv --kernel faces", 2, "the kernel faces finds unions only");
  EXPECT_EQ(folder_.file_count(), 1u);
  const Outcome unused = run("combine A A=a.csv B=none.csv");
  EXPECT_EQ(unused.status, 0);
  EXPECT_EQ(unused.err, "boxunion: warning: B is given, but the expression does not name it\n");
}

TEST_F(Command, BoundaryInFloatsIsSplitAndWarnsIfItRounds) {
  folder_.write("a.csv", "0,0,0,0.1,1,1\n");
  const Outcome r = run("boundary a.csv -o a.stl");
  EXPECT_EQ(r.status, 0);
  EXPECT_EQ(r.err, "boxunion: warning: a.stl: coordinates were rounded to the numbers of this format\n");
  EXPECT_EQ(folder_.read("a.stl").size(), 84u + 50 * 12);
  folder_.write("b.csv", "0,0,0,1e39,1,1\n");
  expect_error("boundary b.csv -o b.stl", 3, "b.stl: no float holds the coordinate 1e+39");
  expect_error("boundary a.csv -o a.ply --nonmanifold drop", 2, "--nonmanifold: drop not in {keep,split}");
  EXPECT_EQ(folder_.file_count(), 3u);
  EXPECT_EQ(run("boundary b.csv -o b.3mf").err, "");  // text has no such limits
}

TEST_F(Command, DecomposeWritesBoxesThatItReadsAgain) {
  // a plus sign of height 1: the arms along the first or the second axis are cut off
  folder_.write("plus.csv", "1,0,0,2,3,1\n0,1,0,3,2,1\n");
  nlohmann::json result = json("decompose plus.csv --json -o xyz.csv --connectivity 6");
  EXPECT_EQ(result.at("model"), "cudb");
  EXPECT_EQ(result.at("order"), "xyz");
  EXPECT_EQ(result.at("boxes"), 3);
  EXPECT_EQ(result.at("neighbors"), 2);
  EXPECT_EQ(result.at("output"), "xyz.csv");
  EXPECT_EQ(folder_.read("xyz.csv"), kHeader + "0,1,0,1,2,1\n1,0,0,2,3,1\n2,1,0,3,2,1\n"s);
  EXPECT_EQ(result.at("bytes"),
            3 * 24 + 4 * (4 * 8 + 2 * 4) - 2 * 2 * 4);  // both axes of 2 pairs in one list
  EXPECT_EQ(json("decompose plus.csv --json --order zyx").at("bytes"), 3 * 24);
  EXPECT_EQ(json("decompose plus.csv --json --order zyx").at("boxes"), 3);
  json("decompose plus.csv --json --order yxz -o yxz.npy");
  for (const char* file : {"plus.csv", "xyz.csv", "yxz.npy"}) {
    const nlohmann::json mass = json("measure --json "s + file);
    EXPECT_EQ(mass.at("volume"), 5);
    EXPECT_EQ(mass.at("vertices"), 24);
  }

  result = json("decompose plus.csv --json --model evm -o evm.csv");
  EXPECT_EQ(result.at("vertices"), 24);
  EXPECT_EQ(result.at("bytes"), 24 * 12);
  EXPECT_TRUE(folder_.read("evm.csv").starts_with("x,y,z\n0,1,0\n0,1,1\n0,2,0\n"));
  // two boxes of different heights side by side, and one along both: cut everywhere, but merged again
  folder_.write("steps.csv", "0,0,0,1,1,1\n1,0,0,2,1,2\n0,5,0,2,6,1\n");
  EXPECT_EQ(json("decompose steps.csv --json --model oudb").at("boxes"), 4);
  EXPECT_EQ(json("decompose steps.csv --json --model cudb").at("boxes"), 3);
  EXPECT_EQ(json("decompose steps.csv --json --model oudb --order best").at("boxes"), 3);
}

TEST_F(Command, LabelNumbersTheComponents) {
  folder_.write("a.csv", "5,0,0,6,1,1\n0,0,0,1,1,1\n1,1,0,2,2,1.5\n1,1,1.5,2,2,3\n");
  EXPECT_EQ(json("label a.csv --json").at("components"), 3);
  const nlohmann::json result = json("label a.csv --json --connectivity 26 -o l.csv --components c.csv");
  EXPECT_EQ(result.at("components"), 2);
  EXPECT_EQ(result.at("connectivity"), 26);
  EXPECT_EQ(result.at("boxes"), 3);
  EXPECT_EQ(folder_.read("l.csv"),
            "xmin,ymin,zmin,xmax,ymax,zmax,label\n0,0,0,1,1,1,1\n5,0,0,6,1,1,2\n1,1,0,2,2,3,1\n");
  EXPECT_EQ(folder_.read("c.csv"),
            "label,boxes,volume,xmin,ymin,zmin,xmax,ymax,zmax\n1,2,4,0,0,0,2,2,3\n2,1,1,5,0,0,6,1,1\n");
  json("label a.csv --json --components c.npy -o l.npy");
  EXPECT_NE(folder_.read("l.npy").find("[('box', '<f8', (6,)), ('label', '<u4')]"), std::string::npos);
  EXPECT_NE(folder_.read("l.npy").find("'shape': (3,)"), std::string::npos);
  EXPECT_EQ(folder_.read("c.npy").size(), 192u + 3 * 72);
  expect_error("label a.csv --connectivity 18", 2, "--connectivity: 18 not in {26,6}");
  expect_error("label a.csv -o l.ply", 3, "l.ply: unknown extension .ply, expected .csv or .npy");
}

TEST_F(Command, ADeviceThatFailsMidwayCostsAWarning) {
  run("generate cubes --count 50 --edge 9 --universe 40 -o a.csv");
  EXPECT_EQ(run("boundary a.csv -o native.csv --device native").status, 0);
  const nlohmann::json listed = json("devices --json");
  for (const nlohmann::json& device : listed.at("devices")) {
    const std::string id = device.at("id");
    if (id == "native") continue;
    for (const char* call :
         {"load:1", "allocate:2", "upload:1", "clear:1", "dispatch:1", "download:1", "wait:1"}) {
      const Outcome r = shell("BOXUNION_FAIL_DEVICE="s + call +
                              " boxunion boundary a.csv -o out.csv --device " + id + " --json");
      EXPECT_EQ(r.status, 0) << id << call;
      EXPECT_TRUE(r.err.starts_with("boxunion: warning: " + id + " failed, continuing natively: ")) << r.err;
      EXPECT_EQ(nlohmann::json::parse(r.out).at("device"), "native");
      EXPECT_EQ(folder_.read("out.csv"), folder_.read("native.csv")) << id << call;
      const Outcome ended = shell("rm out.csv; BOXUNION_FAIL_DEVICE="s + call +
                                  " boxunion boundary a.csv -o out.csv --no-fallback --device " + id);
      EXPECT_EQ(ended.status, 4) << id << call;
      EXPECT_TRUE(ended.err.starts_with("boxunion: error: " + id + " failed: ")) << ended.err;
      EXPECT_EQ(folder_.read("out.csv"), "");
    }
  }
}

TEST_F(Command, SlabsAreStreamedNotHeld) {
  if (sanitized()) GTEST_SKIP() << "sanitizers reserve more than any limit";
  // 4000 nested boxes: 16 million rectangles in 8000 slabs, 256 MB if held at once
  std::string boxes;
  for (int i = 0; i < 4000; ++i)
    boxes += "0,0," + std::to_string(i) + ",1,1," + std::to_string(8000 - i) + "\n";
  folder_.write("nested.csv", boxes);
  const Outcome r = shell(
      "ulimit -v 400000; "
      "boxunion measure nested.csv --method slices --device native --threads 2 --json");
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_EQ(nlohmann::json::parse(r.out).at("volume"), 8000);
}

TEST_F(Command, VolumesAreMeasuredAsTheirBoxes) {
  EXPECT_EQ(json("generate porous --size 30 20 10 --seed 3 -o v.npy --volume --json"),
            (nlohmann::json{{"voxels", 6000}, {"output", "v.npy"}}));
  const nlohmann::json boxes = json("generate porous --size 30 20 10 --seed 3 -o b.csv --json");
  nlohmann::json volume = json("measure v.npy --json"), expected = json("measure b.csv --json");
  EXPECT_EQ(volume.at("boxes"), boxes.at("boxes"));
  EXPECT_EQ(volume.at("volume"), 3000);
  volume.erase("seconds");
  expected.erase("seconds");
  EXPECT_EQ(volume, expected);
  EXPECT_EQ(json("measure v.npy --threshold 2 --json").at("boxes"), 0);
  EXPECT_EQ(run("boundary v.npy -o a.obj").status, 0);
  EXPECT_EQ(run("boundary b.csv -o b.obj").status, 0);
  EXPECT_EQ(folder_.read("a.obj"), folder_.read("b.obj"));
  const nlohmann::json phantom = json("generate phantom --size 64 -o p.npy --json");
  EXPECT_EQ(json("measure p.npy --json").at("boxes"), phantom.at("boxes"));
}

TEST_F(Command, WrongUsageOfVolumesExitsWith2) {
  folder_.write("a.csv", "0,0,0,1,1,1\n");
  expect_error("measure a.csv --threshold 1", 2, "a.csv: found boxes, but a threshold is for voxels");
  expect_error("measure a.csv --model 1", 2, "a.csv: only .vox files have models to choose");
  expect_error("measure a.npy --threshold nan", 2, "--threshold: found \"nan\", expected a finite number");
  expect_error("label a.npy --connectivity 18", 2, "--connectivity: 18 not in {26,6}");
  expect_error("generate porous --size 3 4 -o a.npy", 2, "--size has two numbers, expected one or three");
  expect_error("generate porous --size 3 --porosity 2 -o a.npy", 2, "porosity is 2, expected 0 to 1");
  expect_error("generate phantom --size 0 -o a.npy", 2, "size is 0, expected 1 to 2147483647");
  expect_error("generate phantom --size 3 --volume -o a.csv", 3,
               "a.csv: unknown extension .csv, expected .npy");
  EXPECT_EQ(folder_.file_count(), 1u);
}

TEST_F(Command, LabelWritesTheComponentsOfAVolume) {
  // two voxels that share an edge, and one apart; 3 x 2 x 1 voxels of uint8
  const std::string header = "{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2, 3), }\n";
  folder_.write("v.npy", "\x93NUMPY\1\0"s + char(header.size()) + '\0' + header + "\0\7\0\7\0\7"s);
  const auto counts = [&](const std::string& arguments) {
    nlohmann::json result = json("label v.npy --json " + arguments);
    EXPECT_TRUE(result.at("seconds").contains("total"));
    result.erase("seconds");
    return result;
  };
  EXPECT_EQ(counts("--connectivity 6 -o l.npy"),
            (nlohmann::json{{"components", 3}, {"voxels", 3}, {"connectivity", 6}, {"output", "l.npy"}}));
  const std::string labels = folder_.read("l.npy");
  EXPECT_NE(labels.find("{'descr': '<u4', 'fortran_order': False, 'shape': (1, 2, 3), }"), std::string::npos);
  EXPECT_EQ(labels.substr(128), "\0\0\0\0\1\0\0\0\0\0\0\0\2\0\0\0\0\0\0\0\3\0\0\0"s);
  EXPECT_EQ(counts("--connectivity 26"),
            (nlohmann::json{{"components", 1}, {"voxels", 3}, {"connectivity", 26}}));
  EXPECT_EQ(counts("--connectivity 26 --threshold 8").at("components"), 0);
  folder_.write("bad.npy", folder_.read("v.npy") + "x");
  expect_error("label bad.npy --connectivity 6 -o l.npy", 3,
               "bad.npy: found 1 bytes after the 6 bytes of the voxels, expected none");
  EXPECT_EQ(folder_.read("l.npy"), labels);
  expect_error("label v.npy -o l.csv", 3, "l.csv: unknown extension .csv, expected .npy");
  EXPECT_EQ(counts("--connectivity 26 --components c.csv").at("components_output"), "c.csv");
  EXPECT_EQ(folder_.read("c.csv"), "label,boxes,volume,xmin,ymin,zmin,xmax,ymax,zmax\n1,3,3,0,0,0,3,2,1\n");
}

TEST_F(Command, VolumesAreStreamedNotHeld) {
  if (sanitized()) GTEST_SKIP() << "sanitizers reserve more than any limit";
  // 512 MiB of voxels in a sparse file, measured within 400 MB
  const std::string header = "{'descr': '|u1', 'fortran_order': False, 'shape': (512, 1024, 1024), }\n";
  const std::string start = "\x93NUMPY\1\0"s + char(header.size()) + '\0' + header;
  folder_.write("big.npy", start + "\1");
  std::filesystem::resize_file(folder_.file("big.npy"), start.size() + (std::uintmax_t{1} << 29));
  const Outcome r = shell("ulimit -v 400000; boxunion measure big.npy --device native --threads 2 --json");
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_EQ(nlohmann::json::parse(r.out).at("volume"), 1);
}

TEST_F(Command, VolumesTakeAMemoryBudget) {
  run("generate porous --size 120 --feature 2 --volume -o v.npy --quiet");
  for (const std::string task :
       {"measure v.npy", "measure v.npy --threshold 2", "measure v.npy --statistics",
        "decompose v.npy --connectivity 6 -o out.npy", "boundary v.npy -o out.3mf"}) {
    SCOPED_TRACE(task);
    const auto results = [&](const std::string& memory) {
      nlohmann::json found = json(task + " --device native --json" + memory);
      if (!memory.empty()) {
        EXPECT_EQ(found.at("slabs") > 1, !task.ends_with("2"));
      }
      for (const char* key : {"seconds", "slabs"}) found.erase(key);
      if (found.contains("statistics"))
        for (const char* key : {"cells", "covered_cells", "cell_box_overlaps"})
          found.at("statistics").erase(key);
      return found;
    };
    const nlohmann::json expected = results("");
    const std::string name = expected.value("output", "v.npy"), file = folder_.read(name);
    EXPECT_EQ(results(" --memory 108M"), expected);
    EXPECT_TRUE(folder_.read(name) == file);
  }
  const std::string header = "{'descr': '|u1', 'fortran_order': False, 'shape': (1, 4000, 4000), }\n";
  const std::string start = "\x93NUMPY\1\0"s + char(header.size()) + '\0' + header;
  folder_.write("flat.npy", start);
  std::filesystem::resize_file(folder_.file("flat.npy"), start.size() + 16'000'000);
  expect_error("measure flat.npy --memory 512M", 5,
               "flat.npy: slices of the volume may take 841 MiB, more than --memory allows");
  EXPECT_EQ(json("measure flat.npy --memory 1G --json").at("volume"), 0);
}

TEST_F(Command, DevicesAlwaysListsTheNativeOne) {
  const nlohmann::json result = json("devices --json");
  EXPECT_EQ(result.at("devices").at(0).at("id"), "native");
  EXPECT_TRUE(result.at("notes").is_array());
  EXPECT_TRUE(run("devices").out.starts_with("native"));
}

}  // namespace
}  // namespace boxunion
