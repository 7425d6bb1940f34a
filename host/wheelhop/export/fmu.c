/* A car as a functional mock-up unit for co-simulation, FMI 2.0.
 *
 * model.h has its sizes, matrices and force laws. The equations of motion are linear but for the
 * laws; they are integrated by the classical Runge-Kutta method, as wheelhop itself does:
 * a communication step is divided into equal steps of at most LONGEST_STEP.
 *
 * Within a communication step the ground goes on from what the inputs say at its beginning: height,
 * rate, and the rate's first and second derivative in time. Where the importing tool does not set
 * these two, they follow from the rates at the last communication points.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "model.h"

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef void *fmi2Component;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;

#define U N_INPUTS
#define Y N_OUTPUTS
#define Z (2 * N + 2 * M + K + P)

typedef struct {
  double time, q[2 * N], input[U], start[P + 1], memory[P + 1];
  double rate[3][M], at[3], given[2][M]; /* the last rates, newest first; derivatives set */
  int known, is_given, is_ready;
  double output[Y];
} Car;

static void multiply(double *result, const double *matrix, const double *vector, int rows) {
  for (int i = 0; i < rows; i++) {
    double total = 0.0;
    for (int k = 0; k < Z; k++) total += matrix[i * Z + k] * vector[k];
    result[i] = total;
  }
}

/* First and second derivative of each rate, by the parabola through the last three, or what there
 * is of them. */
static void bends(const Car *car, double (*bend)[M]) {
  for (int j = 0; j < M; j++) {
    bend[0][j] = bend[1][j] = 0.0;
    if (car->is_given) {
      bend[0][j] = car->given[0][j];
      bend[1][j] = car->given[1][j];
    } else if (car->known >= 2) {
      double h = car->at[0] - car->at[1], first = (car->rate[0][j] - car->rate[1][j]) / h;
      bend[0][j] = first;
      if (car->known >= 3) {
        double before = car->at[1] - car->at[2];
        double second = (car->rate[1][j] - car->rate[2][j]) / before;
        bend[1][j] = 2.0 * (first - second) / (h + before);
        bend[0][j] += 0.5 * h * bend[1][j];
      }
    }
  }
}

/* Ground and forces at a time after the communication point, into z. */
static void drive(const Car *car, double (*bend)[M], double since, double *z) {
  double *u = z + 2 * N, *rate = u + M, s = since;
  for (int j = 0; j < M; j++) {
    double a = bend[0][j], b = bend[1][j], r = car->input[M + j];
    u[j] = car->input[j] + s * (r + s * (a / 2 + s * b / 6));
    rate[j] = r + s * (a + s * b / 2);
  }
  for (int j = 0; j < K; j++) rate[M + j] = car->input[2 * M + j];
}

/* Forces of the laws into z, their memories into `after`. */
static void push(const Car *car, double elapsed, double *z, double *after) {
  double port[2 * P + 1];
  multiply(port, EXTENSION, z, 2 * P);
  for (int i = 0; i < P; i++)
    z[Z - P + i] = LAWS[i](port[i], port[P + i], port[i] - car->start[i], elapsed, car->memory[i],
                           NUMBERS[i], after + i);
}

static void step(Car *car, double (*bend)[M], double since, double dt) {
  static const double next[4] = {0.5, 0.5, 1.0, 0.0}, weight[4] = {1, 2, 2, 1};
  static const double half[4] = {0, 1, 1, 2};
  double z[Z], change[2 * N], acceleration[N], after[P + 1];
  memset(z, 0, sizeof z);
  memcpy(z, car->q, sizeof car->q);
  memset(change, 0, sizeof change);
  for (int stage = 0; stage < 4; stage++) {
    double elapsed = 0.5 * dt * half[stage];
    drive(car, bend, since + elapsed, z);
    push(car, elapsed, z, after);
    multiply(acceleration, MOTION, z, N);
    for (int i = 0; i < 2 * N; i++) {
      double rate = i < N ? z[N + i] : acceleration[i - N];
      change[i] += weight[stage] * rate;
      if (i < N) continue;
      z[i - N] = car->q[i - N] + next[stage] * dt * z[i];
      z[i] = car->q[i] + next[stage] * dt * rate;
    }
  }
  for (int i = 0; i < 2 * N; i++) z[i] = car->q[i] += dt / 6.0 * change[i];
  drive(car, bend, since + dt, z);
  push(car, dt, z, after);
  memcpy(car->memory, after, sizeof after);
  double port[2 * P + 1];
  multiply(port, EXTENSION, z, 2 * P);
  memcpy(car->start, port, P * sizeof *port);
}

/* What the outputs show now. */
static void show(Car *car) {
  double z[Z], bend[2][M], after[P + 1];
  memset(bend, 0, sizeof bend);
  memset(z, 0, sizeof z);
  memcpy(z, car->q, sizeof car->q);
  drive(car, bend, 0.0, z);
  push(car, 0.0, z, after);
  multiply(car->output, SHOWN, z, Y);
}

static void forget(Car *car) {
  memset(car, 0, sizeof *car);
}

/* The extensions that the laws begin at: those of the first inputs. */
static void begin(Car *car) {
  double z[Z], bend[2][M], port[2 * P + 1];
  memset(bend, 0, sizeof bend);
  memset(z, 0, sizeof z);
  drive(car, bend, 0.0, z);
  multiply(port, EXTENSION, z, 2 * P);
  memcpy(car->start, port, P * sizeof *port);
  car->is_ready = 1;
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT fmi2Component fmi2Instantiate(fmi2String name, int type, fmi2String guid, fmi2String place,
                                     const void *functions, fmi2Boolean visible, fmi2Boolean log) {
  (void)name, (void)place, (void)functions, (void)visible, (void)log;
  if (type != 1 || strcmp(guid, GUID) != 0) return NULL;
  return calloc(1, sizeof(Car));
}
EXPORT void fmi2FreeInstance(fmi2Component c) { free(c); }
EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n,
                                      const fmi2String categories[]) {
  (void)c, (void)on, (void)n, (void)categories;
  return fmi2OK;
}
EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has, fmi2Real tolerance,
                                      fmi2Real start, fmi2Boolean ends, fmi2Real stop) {
  (void)has, (void)tolerance, (void)ends, (void)stop;
  ((Car *)c)->time = start;
  return fmi2OK;
}
EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return begin(c), fmi2OK; }
EXPORT fmi2Status fmi2Terminate(fmi2Component c) { return (void)c, fmi2OK; }
EXPORT fmi2Status fmi2Reset(fmi2Component c) { return forget(c), fmi2OK; }

EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                              fmi2Real value[]) {
  Car *car = c;
  show(car);
  for (size_t i = 0; i < n; i++) {
    if (vr[i] >= U + Y) return fmi2Error;
    value[i] = vr[i] < U ? car->input[vr[i]] : car->output[vr[i] - U];
  }
  return fmi2OK;
}
EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                              const fmi2Real value[]) {
  for (size_t i = 0; i < n; i++) {
    if (vr[i] >= U) return fmi2Error;
    ((Car *)c)->input[vr[i]] = value[i];
  }
  return fmi2OK;
}

/* Derivatives of the rates of the ground, of first and second order; heights follow from these. */
EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[],
                                              size_t n, const fmi2Integer order[],
                                              const fmi2Real value[]) {
  Car *car = c;
  for (size_t i = 0; i < n; i++) {
    if (vr[i] >= U || order[i] < 1 || order[i] > 2) return fmi2Error;
    if (vr[i] < M || vr[i] >= 2 * M) continue;
    car->given[order[i] - 1][vr[i] - M] = value[i];
    car->is_given = 1;
  }
  return fmi2OK;
}

EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean keeps) {
  Car *car = c;
  double bend[2][M];
  (void)keeps;
  if (!car->is_ready || !(h > 0.0)) return fmi2Error;
  memmove(car->rate[1], car->rate[0], 2 * sizeof car->rate[0]);
  memmove(car->at + 1, car->at, 2 * sizeof *car->at);
  memcpy(car->rate[0], car->input + M, sizeof car->rate[0]);
  car->at[0] = time;
  if (car->known < 3) car->known++;
  bends(car, bend);
  int count = (int)ceil(h / LONGEST_STEP - 1e-9);
  if (count < 1) count = 1;
  for (int i = 0; i < count; i++) step(car, bend, i * h / count, h / count);
  car->is_given = 0;
  memset(car->given, 0, sizeof car->given);
  car->time = time + h;
  for (int i = 0; i < 2 * N; i++)
    if (!isfinite(car->q[i])) return fmi2Error;
  return fmi2OK;
}
EXPORT fmi2Status fmi2CancelStep(fmi2Component c) { return (void)c, fmi2Error; }

/* The whole state, to go back to. */
EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
  if (!*state) *state = malloc(sizeof(Car));
  if (!*state) return fmi2Error;
  memcpy(*state, c, sizeof(Car));
  return fmi2OK;
}
EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  memcpy(c, state, sizeof(Car));
  return fmi2OK;
}
EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
  (void)c;
  free(*state);
  *state = NULL;
  return fmi2OK;
}

/* What FMI 2.0 asks for and this unit does not have. */
#define NOTHING(name, ...) \
  EXPORT fmi2Status name(fmi2Component c, __VA_ARGS__) { return (void)c, fmi2Error; }
#define NO_VALUES(name, type) \
  EXPORT fmi2Status name(fmi2Component c, const fmi2ValueReference vr[], size_t n, type value[]) { \
    return (void)c, (void)vr, (void)value, n ? fmi2Error : fmi2OK; \
  }
NO_VALUES(fmi2GetInteger, fmi2Integer)
NO_VALUES(fmi2GetBoolean, fmi2Boolean)
NO_VALUES(fmi2GetString, fmi2String)
NO_VALUES(fmi2SetInteger, const fmi2Integer)
NO_VALUES(fmi2SetBoolean, const fmi2Boolean)
NO_VALUES(fmi2SetString, const fmi2String)
NOTHING(fmi2SerializedFMUstateSize, fmi2FMUstate state, size_t *size)
NOTHING(fmi2SerializeFMUstate, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
NOTHING(fmi2DeSerializeFMUstate, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
NOTHING(fmi2GetDirectionalDerivative, const fmi2ValueReference unknown[], size_t m,
        const fmi2ValueReference known[], size_t n, const fmi2Real dknown[], fmi2Real dunknown[])
NOTHING(fmi2GetRealOutputDerivatives, const fmi2ValueReference vr[], size_t n,
        const fmi2Integer order[], fmi2Real value[])
NOTHING(fmi2GetStatus, int kind, fmi2Status *value)
NOTHING(fmi2GetRealStatus, int kind, fmi2Real *value)
NOTHING(fmi2GetIntegerStatus, int kind, fmi2Integer *value)
NOTHING(fmi2GetBooleanStatus, int kind, fmi2Boolean *value)
NOTHING(fmi2GetStringStatus, int kind, fmi2String *value)
