// The C side of the emulated board: simavr's struct fields and call-backs behind plain functions.
//
// Internal events are kept with their cycle, for the Rust side to
// fetch after each short run.

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "avr_extint.h"
#include "avr_ioport.h"
#include "avr_uart.h"
#include "sim_avr.h"
#include "sim_elf.h"
#include "sim_interrupts.h"

enum { EVENT_BYTE = 0, EVENT_TICK_DUE = 1, EVENT_TICK_ENTERED = 2 };
enum { MAX_EVENTS = 4096, MAX_EDGES = 1024 };

struct event {
	uint64_t cycle;
	int64_t count;  // of the encoder, as its pins have shown it until now
	uint8_t kind;
	uint8_t byte;
};

struct edge {
	uint64_t cycle;
	int64_t count;
	uint8_t levels;  // bit 0: A, bit 1: B
};

struct shim {
	avr_t *avr;
	elf_firmware_t firmware;
	char port;  // of both encoder pins
	uint8_t pin_a, pin_b, interrupt_a, interrupt_b;
	avr_irq_t *irq_a, *irq_b, *irq_receive;
	struct event events[MAX_EVENTS];
	uint32_t events_used;
	struct edge edges[MAX_EDGES];
	uint32_t edges_used, edge_next;
	int64_t count;
	uint8_t levels;
	int lost_events;
};

static void note(struct shim *shim, uint8_t kind, uint8_t byte) {
	if (shim->events_used == MAX_EVENTS) {
		shim->lost_events = 1;
		return;
	}
	struct event *event = &shim->events[shim->events_used++];
	event->cycle = shim->avr->cycle;
	event->count = shim->count;
	event->kind = kind;
	event->byte = byte;
}

static void on_byte(struct avr_irq_t *irq, uint32_t value, void *param) {
	(void)irq;
	note(param, EVENT_BYTE, value);
}

static void on_tick_due(struct avr_irq_t *irq, uint32_t value, void *param) {
	(void)irq;
	if (value) note(param, EVENT_TICK_DUE, 0);
}

static void on_tick_running(struct avr_irq_t *irq, uint32_t value, void *param) {
	(void)irq;
	if (value) note(param, EVENT_TICK_ENTERED, 0);
}

// Failures show in the firmware's behaviour; simavr's own words would only flood the tests'.
static void quiet(avr_t *avr, const int level, const char *format, va_list arguments) {
	(void)avr;
	(void)level;
	(void)format;
	(void)arguments;
}

static void no_sleep(avr_t *avr, avr_cycle_count_t how_long) {
	(void)avr;
	(void)how_long;
}

// Levels of the pins. Any write to PORT or DDR makes simavr raise the pins again from this value, so it
// has to be kept at the present level.
static void show(struct shim *shim) {
	avr_ioport_external_t external = {
		.name = shim->port,
		.mask = (1 << shim->pin_a) | (1 << shim->pin_b),
		.value = ((shim->levels & 1) << shim->pin_a) | (((shim->levels >> 1) & 1) << shim->pin_b),
	};
	avr_ioctl(shim->avr, AVR_IOCTL_IOPORT_SET_EXTERNAL(shim->port), &external);
	if (shim->irq_a->value != (shim->levels & 1u)) avr_raise_irq(shim->irq_a, shim->levels & 1);
	if (shim->irq_b->value != ((shim->levels >> 1) & 1u))
		avr_raise_irq(shim->irq_b, (shim->levels >> 1) & 1);
}

static avr_cycle_count_t on_edge(avr_t *avr, avr_cycle_count_t when, void *param) {
	(void)when;
	struct shim *shim = param;
	while (shim->edge_next < shim->edges_used && shim->edges[shim->edge_next].cycle <= avr->cycle) {
		shim->levels = shim->edges[shim->edge_next].levels;
		shim->count = shim->edges[shim->edge_next].count;
		shim->edge_next++;
		show(shim);
	}
	return shim->edge_next < shim->edges_used ? shim->edges[shim->edge_next].cycle : 0;
}

// After power-up and after each reset: a low level of a pin must not start a storm of interrupts before
// the firmware has chosen edges.
static void settle(struct shim *shim) {
	avr_extint_set_strict_lvl_trig(shim->avr, shim->interrupt_a, 0);
	avr_extint_set_strict_lvl_trig(shim->avr, shim->interrupt_b, 0);
	show(shim);
}

void shim_free(struct shim *shim) {
	if (shim == NULL) return;
	if (shim->avr != NULL) {
		avr_terminate(shim->avr);
		free(shim->avr);
	}
	free(shim);
}

struct shim *shim_new(const char *processor, const char *elf, char port, uint8_t pin_a, uint8_t pin_b,
                      uint8_t interrupt_a, uint8_t interrupt_b, uint8_t tick_vector) {
	struct shim *shim = calloc(1, sizeof(*shim));
	if (shim == NULL) return NULL;
	shim->port = port;
	shim->pin_a = pin_a;
	shim->pin_b = pin_b;
	shim->interrupt_a = interrupt_a;
	shim->interrupt_b = interrupt_b;
	avr_global_logger_set(quiet);
	if (elf_read_firmware(elf, &shim->firmware) != 0) goto failed;
	strncpy(shim->firmware.mmcu, processor, sizeof(shim->firmware.mmcu) - 1);
	shim->firmware.frequency = 16000000;
	shim->avr = avr_make_mcu_by_name(processor);
	if (shim->avr == NULL) goto failed;
	avr_t *avr = shim->avr;
	avr_init(avr);
	avr_load_firmware(avr, &shim->firmware);
	avr->frequency = 16000000;
	avr->log = LOG_ERROR;
	avr->sleep = no_sleep;
	uint32_t flags = 0;
	avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
	avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_byte, shim);
	avr_irq_t *tick = avr_get_interrupt_irq(avr, tick_vector);
	if (tick == NULL) goto failed;
	avr_irq_register_notify(tick + AVR_INT_IRQ_PENDING, on_tick_due, shim);
	avr_irq_register_notify(tick + AVR_INT_IRQ_RUNNING, on_tick_running, shim);
	shim->irq_receive = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
	shim->irq_a = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(port), pin_a);
	shim->irq_b = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(port), pin_b);
	settle(shim);
	return shim;
failed:
	shim_free(shim);
	return NULL;
}

// The reset line. Memory stays as on the real chip; time continues.
void shim_reset(struct shim *shim) {
	uint64_t cycle = shim->avr->cycle;
	avr_reset(shim->avr);
	shim->avr->cycle = cycle;
	shim->edges_used = shim->edge_next = 0;
	settle(shim);
}

uint64_t shim_cycle(const struct shim *shim) { return shim->avr->cycle; }

uint8_t shim_data(const struct shim *shim, uint16_t address) { return shim->avr->data[address]; }

void shim_set_data(struct shim *shim, uint16_t address, uint8_t value) { shim->avr->data[address] = value; }

int64_t shim_count(const struct shim *shim) { return shim->count; }

void shim_receive(struct shim *shim, uint8_t byte) { avr_raise_irq(shim->irq_receive, byte); }

// Takes over the edges that come before the next call, in order of time.
void shim_set_edges(struct shim *shim, const struct edge *edges, uint32_t count) {
	if (count > MAX_EDGES) count = MAX_EDGES;
	avr_cycle_timer_cancel(shim->avr, on_edge, shim);
	memcpy(shim->edges, edges, count * sizeof(*edges));
	shim->edges_used = count;
	shim->edge_next = 0;
	if (count == 0) return;
	uint64_t now = shim->avr->cycle;
	uint64_t first = edges[0].cycle > now ? edges[0].cycle - now : 0;
	avr_cycle_timer_register(shim->avr, first > 0 ? first : 1, on_edge, shim);
}

// Runs until a cycle (or the end of the instruction that passes it). Not 0: the processor has stopped.
int shim_run(struct shim *shim, uint64_t until) {
	avr_t *avr = shim->avr;
	while (avr->cycle < until) {
		avr->run_cycle_limit = until - avr->cycle;
		if (avr->run_cycle_count > avr->run_cycle_limit) avr->run_cycle_count = avr->run_cycle_limit;
		int state = avr_run(avr);
		if (state == cpu_Done || state == cpu_Crashed) return state;
	}
	return 0;
}

// Hands over what has happened since the last call; returns how many events, or -1 if some were lost.
int shim_events(struct shim *shim, struct event *into) {
	int count = shim->lost_events ? -1 : (int)shim->events_used;
	memcpy(into, shim->events, shim->events_used * sizeof(*into));
	shim->events_used = 0;
	return count;
}

// Address of a variable of the firmware in its memory, or 0.
uint16_t shim_symbol(const struct shim *shim, const char *name) {
	for (uint32_t k = 0; k < shim->firmware.symbolcount; k++) {
		const avr_symbol_t *symbol = shim->firmware.symbol[k];
		if (strcmp(symbol->symbol, name) == 0) return (uint16_t)(symbol->addr & 0xFFFF);
	}
	return 0;
}
