/** Signals, chosen from all that a run has. */

interface PickerProps {
  readonly id: string;
  readonly label: string;
  readonly all: readonly string[];
  readonly chosen: readonly string[];
  readonly onChoose: (paths: readonly string[]) => void;
}

export function SignalPicker({ id, label, all, chosen, onChoose }: PickerProps) {
  return (
    <>
      <label for={id}>{label}</label>
      <select
        id={id}
        value=""
        title={chosen.join(", ")}
        onChange={(event) => {
          const path = event.currentTarget.value;
          event.currentTarget.value = "";
          if (path !== "") onChoose(chosen.includes(path) ? chosen.filter((one) => one !== path) : [...chosen, path]);
        }}
      >
        <option value="">{`${chosen.length}: add or take away …`}</option>
        {all.map((path) => <option key={path} value={path}>{chosen.includes(path) ? `✓ ${path}` : path}</option>)}
      </select>
    </>
  );
}
