// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/dgnc_round.h"

#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/coarse_graph.h"
#include "core/pgo/elected_exchange.h"
#include "core/pgo/round_mail.h"
#include "core/pgo/round_opening.h"
#include "core/pgo/round_updates.h"

namespace covey::pgo {
namespace {

OpeningOptions opening_options(const DgncOptions& options) {
  const bool dgnc = options.solver == RoundSolver::kDgnc;
  OpeningOptions opening{common_hash(options), options.alignment, dgnc, {}};
  if (dgnc && options.robust && options.local_start)
    opening.local = RobustOptions{.barc2 = options.barc2, .each_step = options.meanwhile};
  return opening;
}

ElectedOptions elected_options(const DgncOptions& options) {
  ElectedOptions elected;
  elected.packing = {options.dimension, options.full_covariances};
  elected.barc2 = options.barc2;
  elected.noise = options.noise;
  elected.alignment = options.alignment;
  elected.each_step = options.meanwhile;
  return elected;
}

CoarseOptions coarse_options(const DgncOptions& options) {
  CoarseOptions coarse;
  coarse.barc2 = options.barc2;
  coarse.alignment = options.alignment;
  return coarse;
}

ElectedOptions coarse_elected_options(const DgncOptions& options) {
  ElectedOptions elected = elected_options(options);
  elected.packing = {options.alignment.dimension, false};
  return elected;
}

}  // namespace

struct DgncRound::State {
  State(const RoundName& name, std::vector<int> members, GraphSnapshot graph,
        std::vector<SegmentStart> starts, double mu, const DgncOptions& options_in)
      : options(options_in),
        mail(name, graph.robot, std::move(members)),
        opening(mail, std::move(graph), std::move(starts), mu, opening_options(options)) {}

  bool fits(int robot, const RoundMessage& message) {
    if (updates) return updates->fits(robot, message);
    return exchange ? exchange->fits(robot, message) : opening.fits(robot, message);
  }

  void advance() {
    if (updates) {
      if (!updates->advance(mail)) finish();
      return;
    }
    if (exchange) {
      if (exchange->advance(mail)) return;
      if (!coarse) return finish_exchange();
      bend_starts(exchange->poses(), coarse_options(options), opening.problem());
      exchange.reset();
      return begin_updates();
    }
    opening.advance(mail);
    if (!opening.done()) return;
    if (options.solver == RoundSolver::kElected) {
      COVEY_CHECK(options.robust);
      exchange.emplace(opening.problem(), elected_options(options));
      exchange->send_first(mail);
      return;
    }
    if (options.robust && wants_bending(opening.problem(), coarse_options(options))) {
      coarse.emplace(coarse_problem(opening.problem(), coarse_options(options)));
      exchange.emplace(*coarse, coarse_elected_options(options), true);
      exchange->send_first(mail);
      return;
    }
    begin_updates();
  }

  void begin_updates() {
    updates.emplace(opening.problem(), options);
    updates->send_first(mail);
  }

  void finish() {
    result = round_result(opening.problem(), updates->solution(),
                          options.robust ? options.barc2 : std::numeric_limits<double>::infinity());
    result.stages = updates->stages().stages();
    result.updates = updates->updates();
    result.stage_results = updates->stage_results();
    if (!result.stage_results.empty()) result.gradient = result.stage_results.back().gradient;
    result.bytes = mail.bytes();
    done = true;
  }

  void finish_exchange() {
    result = exchange->result();
    result.bytes = mail.bytes();
    done = true;
  }

  DgncOptions options;
  RoundMail mail;
  RoundOpening opening;
  std::optional<AgreedProblem> coarse;  // is solved first, for all, by the exchange
  std::optional<RoundUpdates> updates;
  std::optional<ElectedExchange> exchange;  // in their place, or before them
  bool done = false;
  RoundResult result;
};

DgncRound::DgncRound(const RoundName& name, std::vector<int> members, GraphSnapshot graph,
                     std::vector<SegmentStart> starts, double mu, const DgncOptions& options)
    : state_(std::make_unique<State>(name, std::move(members), std::move(graph), std::move(starts), mu,
                                     options)) {}
DgncRound::~DgncRound() = default;
DgncRound::DgncRound(DgncRound&&) noexcept = default;

const RoundName& DgncRound::name() const { return state_->mail.name(); }
const std::vector<int>& DgncRound::members() const { return state_->mail.members(); }
bool DgncRound::done() const { return state_->done; }
const RoundResult& DgncRound::result() const { return state_->result; }
int DgncRound::number() const { return state_->mail.number(); }
int DgncRound::updates() const { return state_->updates ? state_->updates->updates() : 0; }
double DgncRound::mu() const { return state_->updates ? state_->updates->stages().mu() : 0.0; }
std::int64_t DgncRound::frame() const { return state_->opening.problem().world(); }

std::uint64_t DgncRound::graph() const { return state_->opening.problem().graph.hash; }

std::vector<SegmentResult> DgncRound::current() const {
  if (!state_->updates) return {};
  return placed_segments(state_->opening.problem(), state_->updates->solution().T_root_K);
}

void DgncRound::stop() {
  COVEY_CHECK(state_->updates.has_value());
  if (!done()) state_->finish();
}

const char* DgncRound::receive(const RoundMessage& message) {
  return done() ? "duplicate" : state_->mail.receive(message);
}

std::vector<int> DgncRound::missing() const { return done() ? std::vector<int>{} : state_->mail.missing(); }

bool DgncRound::advance() {
  State& state = *state_;
  if (done() || !missing().empty()) return false;
  if (!state.mail.all_fit([&](int robot, const RoundMessage& message) { return state.fits(robot, message); }))
    return false;
  state.advance();
  state.mail.forget_before_number();
  return true;
}

std::vector<RoundMessage> DgncRound::take_outgoing() { return state_->mail.take_outgoing(); }
const RoundMessage* DgncRound::resend(int number) const { return state_->mail.resend(number); }

}  // namespace covey::pgo
