// The relief valve of Hos and Champneys by Boost odeint: section points a second, for tests.benchmarks.relief_valve.
//
//   x' = v,  v' = -kappa v - (x + delta) + p,  p' = beta (q - x sqrt(p));  x >= 0, on the seat v -> -r v
//
// relief_valve STEPPER RTOL DURATION FLOW...   with STEPPER dopri5 or bulirsch_stoer, both of dense output.
// A step that leaves the seat's side, at its end or at its least lift within, is cut at the root: Newton's method on
// the dense output, kept in its bracket by bisection, down to 1e-10 of the time. The section is v = 0, falling.
// Prints for each flow: the section points, the CPU seconds, the impacts, the last section point (time, x, p).

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include <boost/numeric/odeint.hpp>

namespace odeint = boost::numeric::odeint;
using State = std::array<double, 3>;

constexpr double kappa = 1.25, delta = 10.0, beta = 20.0, restitution = 0.8;
constexpr double located = 1e-10, at_rest = 1e-9;

struct Valve {
  double flow;
  void operator()(const State &s, State &rate, double) const {
    rate[0] = s[1];
    rate[1] = -kappa * s[1] - (s[0] + delta) + s[2];
    rate[2] = beta * (flow - s[0] * std::sqrt(s[2] > 0 ? s[2] : 0));
  }
};

// Time in [low, high] at which coordinate i of the dense output is 0; its rate is coordinate i + 1, or v'.
template <class Stepper>
double root(Stepper &stepper, const Valve &valve, int i, double low, double high, State &at) {
  State rate;
  stepper.calc_state(low, at);
  const bool rising = at[i] < 0;
  double time = 0.5 * (low + high);
  for (int n = 0; n < 60; ++n) {
    stepper.calc_state(time, at);
    ((at[i] < 0) == rising ? low : high) = time;
    valve(at, rate, time);
    double next = time - at[i] / rate[i];
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double moved = std::fabs(next - time);
    time = next;
    if (moved < located * (1 + std::fabs(time)) || high - low < located) break;
  }
  stepper.calc_state(time, at);
  return time;
}

template <class Stepper>
void run(Stepper stepper, double flow, double duration) {
  const Valve valve{flow};
  const std::clock_t begin = std::clock();
  State s{0.2, 0.0, delta}, at, last{0.2, 0.0, delta};
  double last_time = 0, time = 0;
  long points = 0, impacts = 0;
  stepper.initialize(s, 0.0, 1e-3);
  while (time < duration) {
    const auto span = stepper.do_step(valve);
    const double a = span.first, b = std::fmin(span.second, duration);
    const State &before = stepper.previous_state();
    stepper.calc_state(b, at);
    State end = at;
    double hit = -1, turn = -1;
    if (before[1] * end[1] < 0) turn = root(stepper, valve, 1, a, b, at);  // extremum of the lift
    const State extreme = at;
    if (turn >= 0 && before[1] < 0 && extreme[0] < 0)
      hit = root(stepper, valve, 0, a, turn, at);
    else if (end[0] < 0)
      hit = root(stepper, valve, 0, turn >= 0 ? turn : a, b, at);
    if (turn >= 0 && before[1] > 0 && (hit < 0 || turn < hit)) {
      ++points;
      last = extreme;
      last_time = turn;
    }
    time = b;
    if (hit < 0) continue;
    ++impacts;
    time = hit;
    s = at;
    s[0] = 0;
    s[1] = -restitution * s[1];
    if (s[1] < at_rest) {  // on the seat until the pressure opens it
      s[1] = 0;
      if (s[2] < delta) {
        time += (delta - s[2]) / (beta * flow);
        s[2] = delta;
      }
    }
    stepper.initialize(s, time, stepper.current_time_step());
  }
  const double spent = double(std::clock() - begin) / CLOCKS_PER_SEC;
  std::printf("%ld %.9g %ld %.17g %.17g %.17g\n", points, spent, impacts, last_time, last[0], last[2]);
}

int main(int count, char **given) {
  if (count < 5) return 2;
  const double rtol = std::atof(given[2]), duration = std::atof(given[3]);
  for (int i = 4; i < count; ++i) {
    const double flow = std::atof(given[i]);
    if (!std::strcmp(given[1], "dopri5"))
      run(odeint::make_dense_output(rtol, rtol, odeint::runge_kutta_dopri5<State>()), flow, duration);
    else
      run(odeint::bulirsch_stoer_dense_out<State>(rtol, rtol), flow, duration);
  }
}
