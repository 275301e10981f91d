#include <cstdint>
#include <span>
#include <utility>

#include "core/voxels/voxel_boxes.hpp"
#include "host/command/command.hpp"
#include "host/command/command_output.hpp"
#include "host/engine/threads.hpp"
#include "host/files/files.hpp"

namespace boxunion::command {

void generate(const BoxGenerator& generator, const std::string& output, const Common& common) {
  ProgressBar bar(common.quiet);
  OutputGroup outputs;
  OutputFile file = open_output(output, FileUse::boxes, &outputs);
  with_threads(common.engine, [&] {
    BoxWriter<std::int32_t> writer(file, generator.count);
    std::uint64_t done = 0;
    generator.run([&](std::span<const IntegerBox> boxes) {
      writer.write(boxes);
      done += boxes.size();
      bar.show(double(done) / double(generator.count));
    });
    file.commit();
  });
  bar.clear();
  print_results({count_result("boxes", generator.count), string_result("output", output)}, common.json);
  outputs.publish();
}

void generate_volume(const std::function<Volume()>& generator, bool as_voxels, const std::string& output,
                     const Common& common) {
  OutputGroup outputs;
  OutputFile file = open_output(output, as_voxels ? FileUse::voxels : FileUse::boxes, &outputs);
  Result count;
  with_threads(common.engine, [&] {
    const Volume volume = generator();
    if (as_voxels) {
      count = count_result("voxels", volume.grid.voxels());
      write_volume<std::uint8_t>(volume.grid, volume.inside, std::move(file));
    } else {
      const BoxSet boxes = voxel_boxes(stream_of(volume));
      count = count_result("boxes", boxes.size());
      write_boxes(boxes, std::move(file));
    }
  });
  print_results({count, string_result("output", output)}, common.json);
  outputs.publish();
}

}  // namespace boxunion::command
