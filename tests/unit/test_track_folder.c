/* Tracker with a folder: taking up, damage of each file, one writer and many readers, another grid and clock, kill -9.
 */
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "track_frames.h"

enum { HEADER = 128, LINE = 64 };

static char folder[256], ledger[300], checkpoint[300];

static int set_up(void **unused) {
    (void)unused;
    make_folder(folder, sizeof folder);
    snprintf(ledger, sizeof ledger, "%s/ledger.tlml", folder);
    snprintf(checkpoint, sizeof checkpoint, "%s/checkpoint.tlmc", folder);
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    remove_folder(folder);
    return 0;
}

static void push_range(toliman_track *track, int64_t first, int64_t last) {
    for (int64_t id = first; id <= last; id++)
        push_number(track, id);
}

static void write_at(const char *path, off_t at, const void *bytes, size_t size) {
    const int file = open(path, O_RDWR);
    assert_true(file >= 0);
    assert_int_equal(pwrite(file, bytes, size, at), (ssize_t)size);
    close(file);
}

static off_t size_of(const char *path) {
    struct stat facts;
    assert_int_equal(stat(path, &facts), 0);
    return facts.st_size;
}

static void flip_byte(const char *path, off_t at) {
    unsigned char byte;
    const int file = open(path, O_RDONLY);
    assert_int_equal(pread(file, &byte, 1, at), 1);
    close(file);
    byte ^= 0x10;
    write_at(path, at, &byte, 1);
}

/* A folder with 60 frames, 40 of them in the checkpoint, of which one is denied behind it and one after it. */
static toliman_track_options filled_folder(void) {
    toliman_track_options options = small_options(folder);
    options.sync = TOLIMAN_SYNC_NONE;
    toliman_track *track = make_track(&options);
    small_frame frame;
    push_range(track, 1, 40);
    push_range(track, 1, 5);
    make_frame(&frame, 10);
    frame.pixels[0]++;
    assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_QUARANTINED);
    assert_ok(toliman_track_save(track));
    for (int64_t id = 20; id <= 50; id += 30) {
        push_range(track, id < 41 ? 41 : id, 60);
        make_frame(&frame, id);
        frame.pixels[0]++;
        assert_int_equal(push_one(track, &frame.frame).verdict, TOLIMAN_TRACK_QUARANTINED);
    }
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    return options;
}

static void assert_filled(const toliman_track *track, const toliman_track_options *options, int64_t repeated) {
    toliman_period *clean = clean_period(options);
    for (int64_t id = 1; id <= 60; id++)
        if (id != 10 && id != 20 && id != 50)
            push_clean(clean, id);
    assert_same_periods(period_of(track), clean);
    toliman_period_destroy(clean);
    const toliman_track_info info = info_of(track);
    assert_int_equal(info.accepted + info.outlier, 57);
    assert_int_equal(info.quarantined, 3);
    assert_int_equal(info.repeated, repeated);
    assert_int_equal(info.received, 60 + repeated);
    assert_int_equal(info.committed, 63);
}

static void what_is_committed_is_taken_up(void **unused) {
    (void)unused;
    toliman_track_options options = filled_folder();
    for (int time = 0; time < 2; time++) {
        toliman_track *track = make_track(&options);
        assert_filled(track, &options, 8);
        toliman_track_destroy(track);
    }
    /* Known frames are duplicates, new ones come in; what was not committed is gone. */
    toliman_track *track = make_track(&options);
    assert_int_equal(push_number(track, 60), TOLIMAN_TRACK_DUPLICATE);
    assert_int_equal(push_number(track, 10), TOLIMAN_TRACK_QUARANTINED);
    push_range(track, 61, 70);
    toliman_track_info info = info_of(track);
    assert_int_equal(info.lines, 73);
    assert_int_equal(info.committed, 63);
    toliman_track_destroy(track);
    track = make_track(&options);
    assert_filled(track, &options, 8);
    toliman_track_destroy(track);
    /* A folder of more frames than the capacity. */
    options.capacity = 59;
    assert_fails(toliman_track_create(&options, &track), TOLIMAN_E_CAPACITY, "59 frames");
}

/* Every byte of the checkpoint flipped, cut short or gone: the same sums from the ledger. */
static void checkpoint_costs_nothing_but_time(void **unused) {
    (void)unused;
    toliman_track_options options = filled_folder();
    const off_t size = size_of(checkpoint);
    for (off_t at = 0; at < size; at += at < 64 ? 1 : 401) {
        flip_byte(checkpoint, at);
        toliman_track *track = make_track(&options);
        assert_filled(track, &options, 3);
        toliman_track_destroy(track);
    }
    for (off_t cut = 0; cut < size; cut += 1 + cut) {
        assert_int_equal(truncate(checkpoint, cut), 0);
        toliman_track *track = make_track(&options);
        assert_filled(track, &options, 3);
        toliman_track_destroy(track);
    }
    assert_int_equal(unlink(checkpoint), 0);
    options.flags = TOLIMAN_TRACK_READ_ONLY;
    toliman_track *track = make_track(&options);
    assert_filled(track, &options, 3);
    toliman_track_destroy(track);
    assert_int_equal(access(checkpoint, F_OK), -1);
    options.nf = 0;
    assert_fails(toliman_track_create(&options, &track), TOLIMAN_E_ARGUMENT, "nf = 0: there is no checkpoint");
}

/* Each byte of lines that the disk had: never taken for a crash. Of the tail: cut away. */
static void damaged_ledger_is_told_from_a_torn_one(void **unused) {
    (void)unused;
    toliman_track_options options = small_options(folder);
    options.group = 8;
    toliman_track *track = make_track(&options), *none = NULL;
    push_range(track, 1, 24);
    toliman_track_destroy(track);
    assert_int_equal(size_of(ledger), HEADER + 24 * LINE);
    assert_int_equal(unlink(checkpoint), 0);
    for (off_t at = 0; at < HEADER + 16 * LINE; at += at < HEADER ? 5 : 29) {
        flip_byte(ledger, at);
        assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, "ledger.tlml: ");
        options.flags = TOLIMAN_TRACK_READ_ONLY;
        assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, "ledger.tlml: ");
        options.flags = 0;
        flip_byte(ledger, at);
    }
    flip_byte(ledger, HEADER + 3 * LINE);
    assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, "line 3 is damaged");
    flip_byte(ledger, HEADER + 3 * LINE);
    /* The last group may be torn: line 20 lost, 23 too, a part of a line behind. */
    flip_byte(ledger, HEADER + 20 * LINE + 7);
    write_at(ledger, HEADER + 24 * LINE, "half a line", 11);
    options.flags = TOLIMAN_TRACK_READ_ONLY;
    track = make_track(&options);
    assert_holds(track, &options, 1, 20);
    toliman_track_destroy(track);
    assert_int_equal(size_of(ledger), HEADER + 24 * LINE + 11); /* a reader changes nothing */
    options.flags = 0;
    track = make_track(&options);
    assert_holds(track, &options, 1, 20);
    assert_int_equal(size_of(ledger), HEADER + 20 * LINE);
    push_range(track, 21, 30);
    assert_ok(toliman_track_save(track));
    toliman_track_destroy(track);

    /* Damage in the last group, which the checkpoint holds: refused, and nothing is cut. */
    flip_byte(ledger, HEADER + 29 * LINE + 7);
    assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, "29 lines are whole");
    assert_int_equal(size_of(ledger), HEADER + 30 * LINE);
    flip_byte(ledger, HEADER + 29 * LINE + 7);

    /* Lines that the checkpoint counts and the ledger has not. */
    assert_int_equal(truncate(ledger, HEADER + 29 * LINE), 0);
    assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT,
                 "29 lines are whole, the checkpoint was made of 30");
    options.flags = TOLIMAN_TRACK_REBUILD;
    track = make_track(&options);
    assert_holds(track, &options, 1, 29);
    toliman_track_destroy(track);
    options.flags = 0;
    track = make_track(&options);
    assert_holds(track, &options, 1, 29);
    toliman_track_destroy(track);
    assert_int_equal(unlink(ledger), 0);
    assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, "ledger.tlml: missing");
    assert_fails(toliman_track_load_options(folder, &options), TOLIMAN_E_NOT_FOUND, "ledger.tlml: no such file");
    assert_int_equal(symlink("/etc/passwd", ledger), 0);
    assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_NOT_FOUND, "ledger.tlml");
    assert_null(none);
}

static void one_writer_and_many_readers(void **unused) {
    (void)unused;
    toliman_track_options options = small_options(folder), looking;
    toliman_track *writer = make_track(&options), *none = NULL;
    assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_STATE, "writing to it");
    push_range(writer, 1, 64);
    push_range(writer, 65, 70); /* wait */
    toliman_track_options_init(&looking);
    assert_ok(toliman_track_load_options(folder, &looking));
    assert_true(looking.sigma == SIGMA && looking.value_limit == VALUE_LIMIT && looking.estimator_id == 77);
    assert_true(looking.rows == SIDE && looking.image_cols == SIDE && looking.bin == 1 && looking.bit_depth == 12);
    assert_true(looking.nf == FREQUENCIES && looking.f0 == options.f0 && looking.unit_ns == options.unit_ns);
    looking.flags = TOLIMAN_TRACK_READ_ONLY;
    toliman_track *readers[3];
    for (int i = 0; i < 3; i++) {
        looking.nf = i < 2 ? looking.nf : 0;
        readers[i] = make_track(&looking);
        assert_holds(readers[i], &options, 1, 64);
        assert_fails(toliman_track_save(readers[i]), TOLIMAN_E_STATE, "reading only");
        assert_fails(toliman_track_commit(readers[i]), TOLIMAN_E_STATE, "reading only");
        assert_fails(toliman_track_merge(readers[i], folder), TOLIMAN_E_STATE, "reading only");
        small_frame frame;
        toliman_outcome outcome = {.struct_size = sizeof outcome};
        size_t done;
        make_frame(&frame, 99);
        assert_fails(toliman_track_push(readers[i], &frame.frame, 1, &outcome, &done), TOLIMAN_E_STATE, "reading only");
    }
    push_range(writer, 71, 80);
    assert_ok(toliman_track_save(writer));
    toliman_track_destroy(writer);
    writer = make_track(&options); /* while readers look */
    assert_holds(writer, &options, 1, 80);
    for (int i = 0; i < 3; i++) {
        assert_holds(readers[i], &options, 1, 64);
        toliman_track_destroy(readers[i]);
    }
    toliman_track_destroy(writer);
}

/* The clock changes every time, the grid its frequencies: as if all frames had come then. */
static void another_grid_and_clock_without_frames(void **unused) {
    (void)unused;
    toliman_track_options options = filled_folder();
    const int64_t clock[] = {0, 5000, 30 * DAY_NS, 31 * DAY_NS, 50 * DAY_NS, 50 * DAY_NS + 77};
    toliman_track_options other = options;
    other.clock = clock;
    other.clock_points = 3;
    toliman_track *track = NULL;
    assert_fails(toliman_track_create(&other, &track), TOLIMAN_E_MISMATCH, "another clock");
    other.nf = 30;
    other.df = 0.001;
    other.unit_ns = 3600e9;
    other.period_flags = TOLIMAN_PERIOD_FIXED_MEAN | TOLIMAN_PERIOD_WIDE;
    assert_fails(toliman_track_create(&other, &track), TOLIMAN_E_MISMATCH, "another grid");
    other.flags = TOLIMAN_TRACK_REBUILD;
    toliman_track *rebuilt = make_track(&other);

    toliman_track_options fresh = other;
    fresh.folder = NULL;
    fresh.flags = 0;
    toliman_track *expected = make_track(&fresh);
    for (int64_t id = 1; id <= 60; id++)
        if (id != 10 && id != 20 && id != 50)
            push_number(expected, id);
    assert_same_periods(period_of(rebuilt), period_of(expected));
    assert_int_equal(info_of(rebuilt).repeated, 8);
    push_range(rebuilt, 61, 62);
    push_range(expected, 61, 62);
    assert_ok(toliman_track_commit(rebuilt));
    toliman_track_destroy(rebuilt);
    /* Without words the folder's new grid and clock hold, also for a reader and what is behind the checkpoint. */
    options.nf = 0;
    for (int reading = 0; reading < 2; reading++) {
        options.flags = reading ? TOLIMAN_TRACK_READ_ONLY : 0;
        track = make_track(&options);
        assert_same_periods(period_of(track), period_of(expected));
        toliman_track_destroy(track);
    }
    toliman_track_destroy(expected);
    /* Times that the new grid cannot take are told by their line, and the old state stands. */
    other.df = 1e16;
    assert_fails(toliman_track_create(&other, &track), TOLIMAN_E_RANGE, "ledger.tlml: line 0");
    options.flags = 0;
    track = make_track(&options);
    assert_int_equal(info_of(track).quarantined, 3);
    toliman_track_destroy(track);
}

static uint64_t number_at(const char *path, off_t at, size_t size) {
    uint64_t number = 0;
    const int file = open(path, O_RDONLY);
    assert_int_equal(pread(file, &number, size, at), (ssize_t)size);
    close(file);
    return number;
}

static double double_at(const char *path, off_t at) {
    const uint64_t bits = number_at(path, at, 8);
    double number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

static uint32_t crc32(uint32_t before, const void *data, size_t size) {
    uint32_t crc = ~before;
    for (size_t i = 0; i < size; i++) {
        crc ^= ((const unsigned char *)data)[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static uint64_t fnv1a(const char *text, size_t size) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ (unsigned char)text[i]) * 0x100000001b3u;
    return hash;
}

/* Offsets of lib/FORMATS.md; by another clock, too, after merging. */
static void ledger_is_as_its_format_says(void **unused) {
    (void)unused;
    toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options);
    small_frame frame;
    make_frame(&frame, 5);
    frame.frame.dropped = 70000;
    push_one(track, &frame.frame);
    frame.pixels[1]++;
    push_one(track, &frame.frame);
    push_number(track, 7);
    make_frame(&frame, 8);
    frame.pixels[2] = 4096;
    push_one(track, &frame.frame);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);

    unsigned char bytes[HEADER + 4 * LINE];
    const int file = open(ledger, O_RDONLY);
    assert_int_equal(read(file, bytes, sizeof bytes), sizeof bytes);
    close(file);
    assert_int_equal(size_of(ledger), sizeof bytes);
    assert_memory_equal(bytes, "TLML\1\0\0\0", 8);
    static const uint64_t geometry[] = {SIDE, SIDE, 0, 0, SIDE, SIDE, 1, 12, PIXELS};
    assert_memory_equal(bytes + 16, geometry, sizeof geometry);
    assert_true(double_at(ledger, 88) == SIGMA && double_at(ledger, 96) == VALUE_LIMIT);
    assert_int_equal(number_at(ledger, 104, 8), 77);
    uint32_t chain = crc32(0, bytes, HEADER - 4);
    assert_int_equal(number_at(ledger, HEADER - 4, 4), chain);
    static const int kinds[] = {1, 3, 2, 4}, reasons[] = {0, 0, 0, TOLIMAN_REASON_OVER_RANGE}, ids[] = {5, 5, 7, 8};
    for (int line = 0; line < 4; line++) {
        const off_t at = HEADER + line * LINE;
        make_frame(&frame, ids[line]);
        frame.pixels[1] = (uint16_t)(frame.pixels[1] + (line == 1));
        frame.pixels[2] = line == 3 ? 4096 : frame.pixels[2];
        const uint64_t dropped = line < 2 ? 70000 : 0;
        const uint64_t facts[] = {(uint64_t)frame.frame.camera_ns, dropped, SIDE, SIDE, TOLIMAN_PIXEL_U16};
        const uint32_t content = crc32(crc32(0, facts, sizeof facts), frame.pixels, sizeof frame.pixels);
        assert_true(number_at(ledger, at, 8) == fnv1a("pass-1\0core", 11));
        assert_int_equal(number_at(ledger, at + 8, 4), content);
        assert_int_equal(number_at(ledger, at + 12, 8), ids[line]);
        assert_int_equal(number_at(ledger, at + 20, 8), frame.frame.camera_ns);
        assert_int_equal(number_at(ledger, at + 28, 8), line == 3 ? 0 : frame.frame.camera_ns);
        assert_true(double_at(ledger, at + 36) == (line == 3 ? 0 : value_of_frame(&frame)));
        assert_true(double_at(ledger, at + 44) == SIGMA);
        assert_int_equal(number_at(ledger, at + 52, 1), kinds[line]);
        assert_int_equal(number_at(ledger, at + 53, 1), reasons[line]);
        assert_int_equal(number_at(ledger, at + 54, 2), dropped > 65535 ? 65535 : dropped);
        assert_int_equal(number_at(ledger, at + 56, 4), 0);
        chain = crc32(chain, bytes + at, LINE - 4);
        assert_int_equal(number_at(ledger, at + 60, 4), chain);
    }
    char source[300];
    snprintf(source, sizeof source, "%s-source", folder);
    assert_int_equal(rename(folder, source), 0);
    const int64_t clock[] = {0, 1000};
    options.clock = clock;
    options.clock_points = 1;
    track = make_track(&options);
    assert_ok(toliman_track_merge(track, source));
    assert_int_equal(number_at(ledger, HEADER + 2 * LINE + 28, 8) - number_at(ledger, HEADER + 2 * LINE + 20, 8), 1000);
    toliman_track_destroy(track);
    remove_folder(source);
}

/* Right checksums, and a line that denies a frame which never was. */
static void impossible_lines_are_refused(void **unused) {
    (void)unused;
    toliman_track_options options = small_options(folder), elsewhere = small_options(NULL);
    toliman_track *track = make_track(&options), *none = NULL;
    push_number(track, 1);
    assert_ok(toliman_track_commit(track));
    toliman_track_destroy(track);
    unsigned char line[LINE];
    const uint32_t before = (uint32_t)number_at(ledger, HEADER - 4, 4);
    const int file = open(ledger, O_RDONLY);
    assert_int_equal(pread(file, line, LINE, HEADER), LINE);
    close(file);
    line[52] = 3;
    const uint32_t crc = crc32(before, line, LINE - 4);
    memcpy(line + LINE - 4, &crc, 4);
    write_at(ledger, HEADER, line, LINE);
    assert_fails(toliman_track_create(&options, &none), TOLIMAN_E_FORMAT, "line 0 denies a frame that is not there");
    track = make_track(&elsewhere);
    assert_fails(toliman_track_merge(track, folder), TOLIMAN_E_FORMAT, "line 0 denies a frame that is not there");
    assert_int_equal(info_of(track).received, 0);
    toliman_track_destroy(track);
}

/* A disk that is full: told, nothing more taken, what is acknowledged is there when there is room again. */
static void full_disk_is_told(void **unused) {
    (void)unused;
    toliman_track_options options = small_options(folder);
    options.group = 4;
    toliman_track *track = make_track(&options);
    const struct rlimit limit = {HEADER + 10 * LINE, RLIM_INFINITY}, none = {RLIM_INFINITY, RLIM_INFINITY};
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    push_range(track, 1, 11);
    small_frame frame;
    toliman_outcome outcome = {.struct_size = sizeof outcome};
    size_t done = 9;
    make_frame(&frame, 12);
    assert_fails(toliman_track_push(track, &frame.frame, 1, &outcome, &done), TOLIMAN_E_WRITE, "ledger.tlml: ");
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &none), 0);
    assert_int_equal(done, 0);
    assert_fails(toliman_track_push(track, &frame.frame, 1, &outcome, &done), TOLIMAN_E_WRITE, "has failed before");
    assert_fails(toliman_track_commit(track), TOLIMAN_E_WRITE, "has failed before");
    assert_fails(toliman_track_save(track), TOLIMAN_E_WRITE, "has failed before");
    assert_int_equal(info_of(track).committed, 8);
    assert_int_equal(info_of(track).received, 11);
    toliman_track_destroy(track);
    track = make_track(&options);
    const int64_t there = info_of(track).lines;
    assert_true(there >= 8 && there <= 11);
    assert_holds(track, &options, 1, there);
    push_range(track, 1, 20);
    assert_holds(track, &options, 1, 20);
    toliman_track_destroy(track);
}

/* Lines wait a second at the most, if frames come. */
static void lines_wait_a_second(void **unused) {
    (void)unused;
    const toliman_track_options options = small_options(folder);
    toliman_track *track = make_track(&options);
    push_number(track, 1);
    assert_int_equal(info_of(track).committed, 0);
    usleep(1100000);
    push_number(track, 2);
    assert_int_equal(info_of(track).committed, 2);
    push_number(track, 3);
    assert_int_equal(info_of(track).committed, 2);
    toliman_track_destroy(track);
    toliman_track_options each = options;
    each.sync = TOLIMAN_SYNC_FRAME;
    track = make_track(&each);
    push_number(track, 3);
    assert_int_equal(info_of(track).committed, 3);
    toliman_track_destroy(track);
}

enum { RUN = 400 };

/* Pushes all frames, saves now and then, and says after each how many lines are committed. */
static void run_child(const toliman_track_options *options, int pipe_end) {
    toliman_track *track = NULL;
    if (toliman_track_create(options, &track) != TOLIMAN_OK)
        _exit(1);
    for (int64_t id = 1; id <= RUN; id++) {
        small_frame frame;
        toliman_outcome outcome = {.struct_size = sizeof outcome};
        toliman_track_info info = {.struct_size = sizeof info};
        size_t done;
        make_frame(&frame, id);
        if (toliman_track_push(track, &frame.frame, 1, &outcome, &done) != TOLIMAN_OK ||
            (id % 37 == 0 && toliman_track_save(track) != TOLIMAN_OK) ||
            toliman_track_get_info(track, &info) != TOLIMAN_OK ||
            write(pipe_end, &info.committed, sizeof info.committed) != (ssize_t)sizeof info.committed)
            _exit(1);
    }
    _exit(0);
}

/* A reader sees some of the writer's first lines, whatever that is doing. */
static void look_beside_the_writer(const toliman_track_options *options, int64_t committed) {
    toliman_track_options looking = *options;
    looking.flags = TOLIMAN_TRACK_READ_ONLY;
    for (int look = 0; look < 5; look++) {
        toliman_track *reader = make_track(&looking);
        const int64_t lines = info_of(reader).lines;
        assert_true(lines >= committed && lines <= RUN);
        assert_holds(reader, options, 1, lines);
        committed = lines;
        toliman_track_destroy(reader);
    }
}

static void killed_runs_are_taken_up(void **unused) {
    (void)unused;
    const char *given = getenv("TOLIMAN_KILLS");
    const int kills = given != NULL ? atoi(given) : 30;
    toliman_track_options options = small_options(folder);
    options.group = 16;
    uint64_t random = 11;
    for (int kill_number = 0; kill_number < kills; kill_number++) {
        int ends[2];
        int64_t committed = 0, next;
        assert_int_equal(pipe(ends), 0);
        const pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0)
            run_child(&options, ends[1]);
        close(ends[1]);
        const uint64_t reports = draw(&random, RUN);
        for (uint64_t i = 0; i < reports; i++)
            if (read(ends[0], &next, sizeof next) == (ssize_t)sizeof next)
                committed = next;
        if (reports > 0)
            look_beside_the_writer(&options, committed);
        usleep((useconds_t)draw(&random, 3000));
        kill(child, SIGKILL);
        while (read(ends[0], &next, sizeof next) == (ssize_t)sizeof next)
            committed = next;
        close(ends[0]);
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);

        toliman_track *track = make_track(&options);
        const int64_t there = info_of(track).lines;
        assert_true(there >= committed && there <= RUN);
        assert_holds(track, &options, 1, there);
        push_range(track, 1, RUN); /* resumes by replaying all */
        assert_holds(track, &options, 1, RUN);
        toliman_track_destroy(track);
        assert_int_equal(unlink(ledger) + unlink(checkpoint), 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_is_committed_is_taken_up, set_up, tear_down),
        cmocka_unit_test_setup_teardown(checkpoint_costs_nothing_but_time, set_up, tear_down),
        cmocka_unit_test_setup_teardown(damaged_ledger_is_told_from_a_torn_one, set_up, tear_down),
        cmocka_unit_test_setup_teardown(one_writer_and_many_readers, set_up, tear_down),
        cmocka_unit_test_setup_teardown(another_grid_and_clock_without_frames, set_up, tear_down),
        cmocka_unit_test_setup_teardown(ledger_is_as_its_format_says, set_up, tear_down),
        cmocka_unit_test_setup_teardown(impossible_lines_are_refused, set_up, tear_down),
        cmocka_unit_test_setup_teardown(full_disk_is_told, set_up, tear_down),
        cmocka_unit_test_setup_teardown(lines_wait_a_second, set_up, tear_down),
        cmocka_unit_test_setup_teardown(killed_runs_are_taken_up, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
