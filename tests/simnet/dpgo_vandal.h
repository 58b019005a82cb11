// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Values that a correct member would not send, in messages that decode.

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "core/pgo/agent_message.h"

namespace covey::pgo {

class Vandal {
 public:
  explicit Vandal(std::uint64_t seed) : random_(seed) {}

  AgentMessage operator()(dpgo_beacon_t m) {
    return hit({[&] { m.keyframes = whole(); }, [&] { m.graph = whole(); },
                [&] { m.start_utime = whole(); }}),
           m;
  }
  AgentMessage operator()(dpgo_neighbours_t m) {
    return hit({[&] { scratch(m.robots); }}), m;
  }
  AgentMessage operator()(dpgo_round_t m) {
    return hit({[&] { scratch(m.members); }, [&] { scratch(m.start_utimes); }, [&] { m.round = whole(); }}),
           m;
  }
  AgentMessage operator()(dpgo_request_t m) {
    return hit({[&] { m.number = whole(); }, [&] { scratch(m.robots); }}), m;
  }
  AgentMessage operator()(dpgo_join_t m) {
    hit({[&] { scratch(m.segments); }, [&] { scratch(m.solutions); }, [&] { scratch(m.T_O_K); },
         [&] { m.mu = real(); }, [&] { scratch(m.peers); }, [&] { scratch(m.hashes); },
         [&] { m.number = whole(); }});
    return m;
  }
  AgentMessage operator()(dpgo_keys_t m) {
    return hit({[&] { scratch(m.peers); }, [&] { scratch(m.keys); }}), m;
  }
  AgentMessage operator()(dpgo_keyframes_t m) {
    hit({[&] { m.rotation_unit = static_cast<float>(real()); },
         [&] { m.translation_unit = static_cast<float>(real()); }, [&] { scratch(m.code); },
         [&] { m.number = whole(); }});
    return m;
  }
  AgentMessage operator()(dpgo_alignment_t m) {
    hit({[&] { scratch(m.segments_a); }, [&] { scratch(m.robots_b); }, [&] { scratch(m.segments_b); },
         [&] { scratch(m.inliers); }, [&] { scratch(m.T_A_B); }});
    return m;
  }
  AgentMessage operator()(dpgo_advance_t m) {
    hit({[&] { m.max_residual_sq = static_cast<float>(real()); },
         [&] { m.cost = static_cast<float>(real()); }, [&] { m.penalty = static_cast<float>(real()); },
         [&] { m.gradient_sq = static_cast<float>(real()); }, [&] { m.undecided = whole(); },
         [&] { m.step_sq = real(); }, [&] { scratch(m.products); },
         [&] { m.rotation_unit = static_cast<std::int8_t>(whole()); },
         [&] { m.translation_unit = static_cast<std::int8_t>(whole()); }, [&] { scratch(m.code); }});
    return m;
  }

  AgentMessage operator()(dpgo_coarse_t m) {
    hit({[&] { scratch(m.gradient); }, [&] { scratch(m.rows); }, [&] { scratch(m.columns); },
         [&] { scratch(m.values); }});
    return m;
  }
  AgentMessage operator()(dpgo_relay_t m) {
    hit({[&] { scratch(m.message); }, [&] { m.origin = whole(); }, [&] { m.hops = whole(); }});
    return m;
  }

  AgentMessage operator()(dpgo_graph_t m) {
    hit({[&] { scratch(m.poses); }, [&] { scratch(m.robots_b); }, [&] { scratch(m.segments_a); },
         [&] { scratch(m.sizes); }, [&] { scratch(m.ids_b); }, [&] { scratch(m.values); },
         [&] { scratch(m.precisions); }});
    return m;
  }
  AgentMessage operator()(dpgo_poses_t m) {
    hit({[&] { scratch(m.robots); }, [&] { scratch(m.anchors); }, [&] { scratch(m.anchor_segments); },
         [&] { scratch(m.poses); }, [&] { scratch(m.values); }, [&] { scratch(m.loops); },
         [&] { scratch(m.robots_b); }});
    return m;
  }
  bool strikes() { return random_() % 4 == 0; }

 private:
  void hit(const std::vector<std::function<void()>>& ways) { ways[random_() % ways.size()](); }
  int whole() {
    const int values[] = {-1, 0, 1, 2, 3, 1000, 1 << 30};
    return values[random_() % std::size(values)];
  }
  double real() {
    const double values[] = {-1.0, 0.0, 1e-300, 0.5, 1e9, 1e300, INFINITY, NAN};
    return values[random_() % std::size(values)];
  }
  template <typename T>
  void scratch(std::vector<T>& values) {
    if (values.empty()) return;
    T& value = values[random_() % values.size()];
    if constexpr (std::is_floating_point_v<T>) {
      value = static_cast<T>(real());
    } else {
      value = static_cast<T>(whole());
    }
  }
  std::mt19937_64 random_;
};

}  // namespace covey::pgo
